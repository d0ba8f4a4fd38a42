#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "transport/shm/layout.hpp"
#include "transport/shm/memory.hpp"

namespace hgros::shm {

/// How a session waits for its bell.
struct Patience {
  bool busy = false;                  ///< Never sleeps.
  std::chrono::microseconds spin{0};  ///< Looks for so long before it sleeps.
};

/// This session's bell: its threads sleep here until a peer rings.
///
/// Thread safety: all functions.
/// Invariants: a thread that goes to sleep makes `asleep` odd before it looks for the last time, so a ring is either
/// seen in that look or finds the word odd, and then wakes a sleeper. The word turns even only after that wake-up: a
/// peer that is killed while it rings leaves nobody asleep whom the next one would not wake. While one thread looks
/// without sleeping, others sleep through rings.
class Bell {
 public:
  /// Throws Error if there is no shared memory.
  explicit Bell(Patience patience);

  [[nodiscard]] const std::shared_ptr<const Handle>& handle() const noexcept { return handle_; }

  /// Returns when somebody has rung or woken, or earlier for no reason.
  void Wait() noexcept;
  /// Takes the numbers of peers that have rung: calls `look(number)` for each.
  template <class Look>
  bool Take(Look&& look) {
    bool any = false;
    for (std::uint32_t word = 0; word < kMaxPeers / 64; ++word) {
      if (page_.ready[word].load(std::memory_order_relaxed) == 0) continue;
      std::uint64_t bits = page_.ready[word].exchange(0);
      any = true;
      for (; bits != 0; bits &= bits - 1) look(word * 64 + static_cast<std::uint32_t>(__builtin_ctzll(bits)));
    }
    return any;
  }
  [[nodiscard]] bool Rung() const noexcept;
  /// Rings for the peer's number: it is to be looked at again.
  void Ring(std::uint32_t number) noexcept;
  /// Ends one wait.
  void Wake() noexcept;
  /// Undoes what a peer may have done to the page, which all of them can write: now and then, for those that lie.
  void Mend() noexcept;
  /// The calling thread stops looking for a while: a sleeping one is to be woken by what comes, or has come.
  void PassOn() noexcept;
  /// The calling thread looks from here on: nobody is woken. False if another one looks already.
  [[nodiscard]] bool BeginLooking() noexcept;
  void EndLooking() noexcept;
  /// Whether a peer has rung.
  [[nodiscard]] bool HasRung() const noexcept;

 private:
  [[nodiscard]] bool Spin() const noexcept;

  const Patience patience_;
  std::shared_ptr<const Handle> handle_;
  std::shared_ptr<Mapping> mapping_;
  BellPage& page_;
  std::atomic<bool> woken_{false};
  std::atomic<bool> spinning_{false};
};

/// Another session's bell.
/// Thread safety: all functions.
class PeerBell {
 public:
  PeerBell(std::shared_ptr<Mapping> mapping, std::uint32_t number) noexcept
      : mapping_(std::move(mapping)), number_(number) {}

  /// Null, and `fault` is set, if this is no bell.
  [[nodiscard]] static std::unique_ptr<PeerBell> Open(const Handle& handle, std::uint32_t number, std::string& fault);

  /// Has the peer look at us. Costs a system call only if it sleeps.
  void Ring() const noexcept;

 private:
  const std::shared_ptr<Mapping> mapping_;
  const std::uint32_t number_;  // Of this session, at the peer.
};

}  // namespace hgros::shm
