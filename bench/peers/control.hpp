#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "shared_counter.hpp"
#include "task.hpp"

namespace hgros::bench {

/// What the two processes of a measurement tell each other. It carries no payload; all zeroes is the initial state.
struct Control {
  static constexpr std::size_t kTimed = 4096;
  SharedCounter subscribed;  ///< Lanes on which a receiver listens or listened, of all receivers together.
  SharedCounter probed;      ///< Likewise lanes on which a probe arrived.
  SharedCounter timed;       ///< Likewise timed messages that arrived.
  SharedCounter finished;    ///< Lanes that the sender is done with.
  std::array<std::atomic<std::int64_t>, kTimed> latency_ns;  ///< Of the present lane's timed messages: until the last
                                                             ///< receiver had it; 0: nobody has it yet.
  std::atomic<std::uint64_t> flooded;                        ///< Flood messages of the present lane that arrived.
  std::atomic<std::int64_t> last_flooded_ns;
  std::atomic<std::uint64_t> damaged;  ///< Messages that were not what had been sent.
};

/// Opens (and makes) the task's control file, or memory of this process alone. Exits with a sentence if that fails.
Control& OpenControl(const Task& task);

/// What a receiver hands its messages to.
///
/// Threading: Note is called by one thread at a time.
class Sink {
 public:
  Sink(const Lane& lane, Control& control) : lane_(lane), control_(control) {}
  /// To be called as soon as the message can be read, with all of it readable.
  void Note(const void* bytes, std::size_t size_bytes);

 private:
  const Lane& lane_;
  Control& control_;
  bool probed_ = false;
};

}  // namespace hgros::bench
