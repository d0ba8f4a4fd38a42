#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace hgros::bench {

/// A measurement with messages of one size on its own channel. Nothing is measured if `timed` and `flood_ms` are 0.
struct Lane {
  std::uint32_t index;  ///< Counts the lanes of a run.
  std::size_t size_bytes;
  int timed;                                ///< Number of messages whose latency is measured.
  int flood_ms;                             ///< Time of publishing at full speed; 0: none.
  int pause_us;                             ///< Between the arrival of a timed message and the next.
  int warm_up;                              ///< Number of messages before the measured ones.
  int transit_us;                           ///< Time of a message on the line alone; 0 on this machine.
  std::string name;                         ///< Of topic, socket or segment; unique on this machine.
  int port;                                 ///< For peers that need one.
  [[nodiscard]] std::size_t depth() const;  ///< Depth of the queues on both sides, if the peer lets us choose it.
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
