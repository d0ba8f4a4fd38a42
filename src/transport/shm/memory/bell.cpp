#include "transport/shm/memory/bell.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <ctime>
#include <new>

#include "hgros/base/error.hpp"

namespace hgros::shm {
namespace {

// The lowest bit of the word means that a thread sleeps. The other bits change each time that this bit changes, so
// that no thread sleeps on an old value.
constexpr std::uint32_t kAsleep = 1;
constexpr std::uint32_t kTurn = 2;

// The private variants of these calls do not work here: processes share the word.
void FutexWait(Shared32& word, std::uint32_t value) noexcept {
  syscall(SYS_futex, &word, FUTEX_WAIT, value, nullptr, nullptr, 0);
}

void FutexWakeOne(Shared32& word) noexcept { syscall(SYS_futex, &word, FUTEX_WAKE, 1, nullptr, nullptr, 0); }

void FutexWakeAll(Shared32& word) noexcept { syscall(SYS_futex, &word, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0); }

// Those that sleep on one word sleep on the other from here on.
void FutexMoveAll(Shared32& from, Shared32& to) noexcept {
  syscall(SYS_futex, &from, FUTEX_REQUEUE, 0, static_cast<std::uintptr_t>(INT_MAX), &to, 0);
}

// False: a signal's handler has run.
bool FutexWaitUntil(Shared32& word, std::uint32_t value, std::chrono::steady_clock::time_point until) noexcept {
  const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(until.time_since_epoch()).count();
  const timespec time{ns / 1'000'000'000, ns % 1'000'000'000};
  const timespec* const limit = until == std::chrono::steady_clock::time_point::max() ? nullptr : &time;
  return syscall(SYS_futex, &word, FUTEX_WAIT_BITSET, value, limit, nullptr, FUTEX_BITSET_MATCH_ANY) == 0 ||
         errno != EINTR;
}

void Pause() noexcept {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

/// Marks that a thread sleeps or is about to. Returns the value to sleep on.
std::uint32_t MarkAsleep(Shared32& word) noexcept {
  std::uint32_t seen = word.load();
  while (!word.compare_exchange_weak(seen, (seen + kTurn) | kAsleep)) {
  }
  return (seen + kTurn) | kAsleep;
}

void MarkAwake(Shared32& word) noexcept { word.fetch_and(~kAsleep); }

// The process that rings may be killed or stopped between any two of these steps. The mark is only removed after the
// wake-up, so the next ring still wakes the sleeper. The word changes before the wake-up, so a thread that is about to
// sleep does not. The mark stays if another thread has gone to sleep meanwhile.
void WakeSleeper(Shared32& word) noexcept {
  const std::uint32_t seen = word.load();
  if ((seen & kAsleep) == 0) return;
  std::uint32_t expected = seen;
  const bool turned = word.compare_exchange_strong(expected, seen + kTurn);
  FutexWakeOne(word);
  expected = seen + kTurn;
  if (turned) word.compare_exchange_strong(expected, seen + kTurn + 1);
}

void RingPage(BellPage& page, std::uint32_t number) noexcept {
  const std::uint64_t bit = std::uint64_t{1} << (number % 64);
  // Both are sequentially consistent: either the sleeper's last look sees the bit, or this call sees that it sleeps.
  page.ready[number / 64 % (kMaxPeers / 64)].fetch_or(bit);
  WakeSleeper(page.asleep);
}

}  // namespace

SessionBell::SessionBell(Patience patience)
    : patience_(patience), page_([this]() -> BellPage& {
        Segment segment = MakeSegment("hgros-bell", sizeof(BellPage), Access::kEverybody, Pages::kAtOnce);
        if (!segment.mapping)
          throw Error("There is no shared memory: " + segment.fault + ".", {},
                      "Free memory or open files, or switch shared memory off.");
        handle_ = std::make_shared<const Handle>(std::move(segment.handle));
        mapping_ = std::move(segment.mapping);
        auto* page = new (mapping_->bytes().data()) BellPage{};
        page->magic = kBellMagic;
        page->version = kLayoutVersion;
        return *page;
      }()) {}

bool SessionBell::HasRung() const noexcept {
  return std::ranges::any_of(page_.ready, [](const Shared64& word) { return word.load() != 0; });
}

bool SessionBell::Rung() const noexcept { return woken_.load() || HasRung(); }

bool SessionBell::Spin() const noexcept {
  constexpr int kLooksPerClock = 64;
  const auto end = std::chrono::steady_clock::now() + patience_.spin;
  do {
    for (int i = 0; i < kLooksPerClock; ++i) {
      if (Rung()) return true;
      Pause();
    }
  } while (patience_.busy || std::chrono::steady_clock::now() < end);
  return false;
}

void SessionBell::Wait() noexcept {
  if (patience_.busy || patience_.spin.count() > 0) {
    if (!spinning_.exchange(true)) {
      MarkAwake(page_.asleep);
      const bool rung = Spin();
      spinning_.store(false);
      if (rung) {
        woken_.store(false);
        return;
      }
    } else {
      const std::uint32_t seen = page_.asleep.load();
      // The looking thread changes the word after it has stopped. If it has already stopped, this thread sleeps like
      // any other.
      if (spinning_.load()) {
        if (!woken_.exchange(false)) FutexWait(page_.asleep, seen);
        return;
      }
    }
  }
  const std::uint32_t marked = MarkAsleep(page_.asleep);
  if (Rung()) {
    MarkAwake(page_.asleep);
  } else {
    FutexWait(page_.asleep, marked);
  }
  woken_.store(false);
}

bool SessionBell::WaitFirst(const std::function<bool()>& ends, std::chrono::steady_clock::time_point until) noexcept {
  // A wake-up goes to the thread that has slept for longest. This one is first if the others sleep elsewhere meanwhile.
  FutexMoveAll(page_.asleep, elsewhere_);
  first_waits_.store(true);
  const std::uint32_t marked = MarkAsleep(page_.asleep);
  bool undisturbed = true;
  if (Rung() || ends()) {
    MarkAwake(page_.asleep);
  } else {
    undisturbed = FutexWaitUntil(page_.asleep, marked, until);
  }
  first_waits_.store(false);
  woken_.store(false);
  FutexMoveAll(elsewhere_, page_.asleep);
  return undisturbed;
}

void SessionBell::WakeFirst() noexcept {
  page_.asleep.fetch_add(kTurn);
  if (first_waits_.load()) FutexWakeAll(page_.asleep);
}

void SessionBell::Ring(std::uint32_t number) noexcept { RingPage(page_, number); }

void SessionBell::Wake() noexcept {
  woken_.store(true);
  page_.asleep.fetch_add(kTurn);
  FutexWakeOne(page_.asleep);
}

void SessionBell::Mend() noexcept {
  page_.magic = kBellMagic;
  page_.version = kLayoutVersion;
  if (Rung()) Wake();
}

void SessionBell::PassOn() noexcept {
  if (spinning_.load()) return;
  (void)MarkAsleep(page_.asleep);
  if (Rung()) WakeSleeper(page_.asleep);
}

bool SessionBell::BeginLooking() noexcept {
  if (spinning_.exchange(true)) return false;
  MarkAwake(page_.asleep);
  return true;
}

void SessionBell::EndLooking() noexcept {
  spinning_.store(false);
  PassOn();
}

std::unique_ptr<PeerBell> PeerBell::Open(const Handle& handle, std::uint32_t number, std::string& fault) {
  if (number >= kMaxPeers) {
    fault = "bell number " + std::to_string(number) + " is too large";
    return nullptr;
  }
  auto mapping = MapForeign(handle, sizeof(BellPage), true, fault);
  if (!mapping) return nullptr;
  const auto& page = mapping->as<BellPage>();
  if (page.magic != kBellMagic || page.version != kLayoutVersion) {
    fault = "it is not a bell of this layout";
    return nullptr;
  }
  return std::make_unique<PeerBell>(std::move(mapping), number);
}

void PeerBell::Ring() const noexcept { RingPage(mapping_->as<BellPage>(), number_); }

}  // namespace hgros::shm
