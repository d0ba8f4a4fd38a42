#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "transport/shm/memory/layout.hpp"
#include "transport/shm/memory/memory.hpp"

namespace hgros::shm {

/// How the threads of a session wait for its bell.
struct Patience {
  bool busy = false;                  ///< Never sleep.
  std::chrono::microseconds spin{0};  ///< How long to look before sleeping.
};

/// This session's bell: its threads sleep here until a peer rings.
///
/// Thread safety: all functions.
/// Invariants: a thread makes `asleep` odd before it looks for the last time and sleeps. So a ring is either seen by
/// that look, or finds the word odd and wakes a sleeper. The word turns even only after that wake-up: if a peer is
/// killed while it rings, the next ring wakes the sleeper. While one thread looks without sleeping, rings wake no other
/// thread.
class SessionBell {
 public:
  /// Throws Error if there is no shared memory.
  explicit SessionBell(Patience patience);

  [[nodiscard]] const std::shared_ptr<const Handle>& handle() const noexcept { return handle_; }

  /// Returns after a ring or Wake(), or earlier for no reason.
  void Wait() noexcept;
  /// As Wait(), for one thread at a time: until it returns, a ring wakes this thread and no other that sleeps. It does
  /// not sleep if `ends()`, nor for longer than `until`. False: a signal's handler has run.
  [[nodiscard]] bool WaitFirst(const std::function<bool()>& ends, std::chrono::steady_clock::time_point until) noexcept;
  /// Lets WaitFirst() return, or look at `ends` once more.
  void WakeFirst() noexcept;
  /// Clears all rings, and calls `look(number)` for each peer that has rung. False if none has.
  template <class Look>
  bool CollectRings(Look&& look) {
    bool any = false;
    for (std::uint32_t word = 0; word < kMaxPeers / 64; ++word) {
      if (page_.ready[word].load(std::memory_order_relaxed) == 0) continue;
      std::uint64_t bits = page_.ready[word].exchange(0);
      any = true;
      for (; bits != 0; bits &= bits - 1) look(word * 64 + static_cast<std::uint32_t>(__builtin_ctzll(bits)));
    }
    return any;
  }
  /// Whether a peer has rung, or Wake() was called.
  [[nodiscard]] bool Rung() const noexcept;
  /// Rings as if that peer had rung, so that it is looked at again.
  void Ring(std::uint32_t number) noexcept;
  /// Ends one wait.
  void Wake() noexcept;
  /// Repairs the page, which every peer can write to. Call it periodically, in case a peer has damaged the page.
  void Mend() noexcept;
  /// The calling thread stops looking for a while: rings, including earlier ones, wake a sleeping thread.
  void PassOn() noexcept;
  /// From here on the calling thread looks, and rings wake no other. False if another thread looks already.
  [[nodiscard]] bool BeginLooking() noexcept;
  void EndLooking() noexcept;
  /// Whether a peer has rung.
  [[nodiscard]] bool HasRung() const noexcept;
  /// Whether threads sleep at once, and do not look for a while before.
  [[nodiscard]] bool sleeps_at_once() const noexcept { return !patience_.busy && patience_.spin.count() == 0; }

 private:
  [[nodiscard]] bool Spin() const noexcept;

  const Patience patience_;
  std::shared_ptr<const Handle> handle_;
  std::shared_ptr<Mapping> mapping_;
  BellPage& page_;
  std::atomic<bool> woken_{false};
  std::atomic<bool> spinning_{false};
  std::atomic<bool> first_waits_{false};
  Shared32 elsewhere_{0};  // Where the others sleep while one waits first.
};

/// Another session's bell.
/// Thread safety: all functions.
class PeerBell {
 public:
  PeerBell(std::shared_ptr<Mapping> mapping, std::uint32_t number) noexcept
      : mapping_(std::move(mapping)), number_(number) {}

  /// Null, and `fault` is set, if `handle` is not a bell.
  [[nodiscard]] static std::unique_ptr<PeerBell> Open(const Handle& handle, std::uint32_t number, std::string& fault);

  /// Rings: the peer will look at us. This costs a system call only if the peer sleeps.
  void Ring() const noexcept;

 private:
  const std::shared_ptr<Mapping> mapping_;
  const std::uint32_t number_;  // This session's bit in the peer's bell.
};

}  // namespace hgros::shm
