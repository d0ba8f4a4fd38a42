#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "shared_counter.hpp"
#include "task.hpp"

namespace hgros::bench {

/// State that the two processes of a measurement share. It carries no payload. All zeroes is the initial state.
struct Control {
  static constexpr std::size_t kTimed = 4096;
  SharedCounter subscribed;  ///< Lanes that a receiver has subscribed to, summed over all receivers.
  SharedCounter probed;      ///< Likewise, lanes on which a probe arrived.
  SharedCounter timed;       ///< Likewise, timed messages that arrived.
  SharedCounter finished;    ///< Lanes that the sender has finished.
  std::array<std::atomic<std::int64_t>, kTimed> latency_ns;  ///< Per timed message of the current lane: until the last
                                                             ///< receiver had it; 0: no receiver has it yet.
  std::atomic<std::uint64_t> flooded;                        ///< Flood messages of the current lane that arrived.
  std::atomic<std::int64_t> last_flooded_ns;
  std::atomic<std::uint64_t> damaged;  ///< Messages whose contents differed from what was sent.
};

/// Opens the task's control file, or creates it; uses memory of this process if there is only one. Exits with an error
/// message if that fails.
Control& OpenControl(const Task& task);

/// Takes the messages of a receiver.
///
/// Threading: Note is called by one thread at a time.
class Sink {
 public:
  Sink(const Lane& lane, Control& control) : lane_(lane), control_(control) {}
  /// Called as soon as the message can be read, when all of it is readable.
  void Note(const void* bytes, std::size_t size_bytes);

 private:
  const Lane& lane_;
  Control& control_;
  bool probed_ = false;
};

}  // namespace hgros::bench
