#pragma once

namespace hgros {

/// How a session's threads wait for messages in shared memory.
enum class ShmWait {
  kSleep,  ///< Costs nothing while no message comes; waking a thread takes some microseconds.
  kSpin,   ///< Polls for SharedMemoryConfig::spin_us before it sleeps.
  kBusy,   ///< Polls all the time: lowest latency, but uses one CPU.
};

}  // namespace hgros
