#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace hgros::bench {

/// A measurement with messages of one size on its own channel. If `timed` and `flood_ms` are 0, nothing is measured.
struct Lane {
  std::uint32_t index;  ///< Position among the lanes of a run.
  std::size_t size_bytes;
  int timed;                                ///< Number of messages whose latency is measured.
  int flood_ms;                             ///< Duration of publishing at full speed; 0: none.
  int pause_us;                             ///< Between the arrival of a timed message and the next.
  int warm_up;                              ///< Number of messages before the measured ones.
  int transit_us;                           ///< Time of a message on the line alone; 0 on this machine.
  std::string name;                         ///< Name of topic, socket or segment; unique on this machine.
  int port;                                 ///< For peers that need one.
  [[nodiscard]] std::size_t depth() const;  ///< Queue depth on both sides, if the peer allows a choice.
};

/// How the runner calls a program: `peer_NAME ROLE MODE --name N --control FILE --folder DIR --port P --lanes L`,
/// with lanes as "SIZE:TIMED:FLOOD_MS:PAUSE_US:WARM_UP:TRANSIT_US,..."; between hosts also `--own A --other A`, and
/// with several receivers `--receivers N --receiver I`.
struct Task {
  enum class Role { kPublish, kSubscribe, kBoth };
  Role role = Role::kBoth;
  std::string mode;  ///< One of the peer's ways to send messages.
  std::string name;
  std::string control;  ///< File that the two processes share; empty if there is only one.
  std::string folder;   ///< For socket files.
  std::string own_address = "127.0.0.1";
  std::string other_address = "127.0.0.1";  ///< Where the other side of a measurement is.
  std::uint32_t receivers = 1;              ///< Processes that receive; each gets every message.
  std::uint32_t receiver = 0;               ///< Index of this one.
  std::vector<Lane> lanes;

  /// Exits with an error message if the arguments are wrong.
  static Task Parse(int argc, char** argv);
  [[nodiscard]] std::size_t largest_bytes() const;
  [[nodiscard]] const std::string& sender_address() const;
  [[nodiscard]] const std::string& receiver_address() const;
};

/// Prints why nothing can be measured, and ends the process.
[[noreturn]] void Fail(const std::string& why);

}  // namespace hgros::bench
