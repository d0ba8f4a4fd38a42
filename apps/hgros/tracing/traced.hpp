#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <hgros/Trace.pb.h>

#include "hgros/base/ids.hpp"
#include "hgros/clock/clock_offset.hpp"

namespace hgros::cli {

class Robot;

/// The difference of two times that peers wrote: any numbers, so it wraps instead of overflowing.
[[nodiscard]] constexpr std::int64_t Difference(std::int64_t a, std::int64_t b) noexcept {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
}

/// What the nodes of a robot have done for a while. All times are those of this host's wall clock, in ns.
struct Traced {
  struct Session {
    SessionId id;
    std::string process;
    std::string host;
    std::int64_t pid = 0;
    std::optional<ClockOffset> clock;  ///< How far its host's clock is ahead of ours; empty: unknown, taken as 0.
  };
  struct Publish {
    std::size_t session = 0;  ///< Index in `sessions`.
    std::string channel;
    std::string node;  ///< In whose callback it was; empty: in none.
    std::uint32_t thread = 0;
    std::uint64_t message = 0;  ///< Its key.
    std::uint64_t cause = 0;
    std::int64_t at_ns = 0;
  };
  struct Run {
    std::size_t session = 0;
    std::string channel;
    std::string node;
    std::uint32_t thread = 0;
    std::uint64_t message = 0;
    std::optional<std::int64_t> sent_ns;  ///< When its publisher had encoded it; empty: in the same process.
    std::int64_t received_ns = 0;
    std::int64_t start_ns = 0;
    std::int64_t end_ns = 0;
  };
  std::vector<Session> sessions;
  std::vector<Publish> publishes;
  std::vector<Run> runs;
  std::uint64_t lost = 0;  ///< Events that were not recorded.
};

/// What one session has sent.
using TraceMessage = std::pair<SessionId, std::shared_ptr<const Trace>>;

/// Without the library's own channels. The messages may contain anything; each message is published once, and no
/// callback ends before it starts or starts before its message came.
[[nodiscard]] Traced Assemble(std::span<const TraceMessage> messages, const std::map<SessionId, ClockOffset>& clocks);

/// Watches all sessions for that time, or until the user ends the command. Says which sessions did not answer. Empty if
/// all of this takes longer than `timeout`, which it says.
[[nodiscard]] std::optional<Traced> Watch(Robot& robot, std::chrono::nanoseconds time,
                                          std::chrono::nanoseconds timeout);

/// A line for each host whose clock differs from ours: by how much, and how exactly that is known.
[[nodiscard]] std::vector<std::string> DescribeClocks(const Traced& traced, bool exact);

}  // namespace hgros::cli
