#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace hgros::bench {

/// What is measured with messages of one size; nothing at all if `timed` and `flood_ms` are 0. Every lane has a channel
/// of its own.
struct Lane {
  std::uint32_t index;  ///< Counts the lanes of a run.
  std::size_t size_bytes;
  int timed;                                ///< So many messages whose latency counts.
  int flood_ms;                             ///< So long as fast as it goes; 0: not.
  int pause_us;                             ///< Between the arrival of a timed message and the next.
  int warm_up;                              ///< So many messages before those that count.
  int transit_us;                           ///< What the line alone takes for a message; 0 on this machine.
  std::string name;                         ///< Of topic, socket or segment; unique on this machine.
  int port;                                 ///< For who needs one.
  [[nodiscard]] std::size_t depth() const;  ///< Of the queues on both sides, wherever a peer lets us choose.
};

/// What the runner asks of a program: `peer_NAME ROLE MODE --name N --control FILE --folder DIR --port P --lanes L`,
/// with lanes as "SIZE:TIMED:FLOOD_MS:PAUSE_US:WARM_UP:TRANSIT_US,..."; between hosts also `--own A --other A`, and
/// with several receivers `--receivers N --receiver I`.
struct Task {
  enum class Role { kPublish, kSubscribe, kBoth };
  Role role = Role::kBoth;
  std::string mode;  ///< One of the peer's ways to carry messages.
  std::string name;
  std::string control;  ///< File that the two processes share; empty if there is only one.
  std::string folder;   ///< For socket files.
  std::string own_address = "127.0.0.1";
  std::string other_address = "127.0.0.1";  ///< Where the other side of a measurement is.
  std::uint32_t receivers = 1;              ///< Processes that receive; each gets every message.
  std::uint32_t receiver = 0;               ///< Which of them this one is.
  std::vector<Lane> lanes;

  /// Exits with a sentence if the arguments do not fit.
  static Task Parse(int argc, char** argv);
  [[nodiscard]] std::size_t largest_bytes() const;
  [[nodiscard]] const std::string& sender_address() const;
  [[nodiscard]] const std::string& receiver_address() const;
};

/// Says why there is nothing to measure, and ends the process.
[[noreturn]] void Fail(const std::string& why);

}  // namespace hgros::bench
