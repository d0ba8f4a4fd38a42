#include "transport/shm/bell.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <new>

#include "hgros/base/error.hpp"

namespace hgros::shm {
namespace {

// Values of the word: only the second one makes a ring wake somebody.
constexpr std::uint32_t kAwake = 0;
constexpr std::uint32_t kAsleep = 1;
constexpr std::uint32_t kWoken = 2;
constexpr std::uint32_t kWokenAgain = 3;

// Not the private variants: the word lies in memory that processes share.
void FutexWait(Shared32& word, std::uint32_t value) noexcept {
  syscall(SYS_futex, &word, FUTEX_WAIT, value, nullptr, nullptr, 0);
}

void FutexWakeOne(Shared32& word) noexcept { syscall(SYS_futex, &word, FUTEX_WAKE, 1, nullptr, nullptr, 0); }

void Pause() noexcept {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

void RingPage(BellPage& page, std::uint32_t number) noexcept {
  const std::uint64_t bit = std::uint64_t{1} << (number % 64);
  Shared64& word = page.ready[number / 64 % (kMaxPeers / 64)];
  // Both are sequentially consistent: either the sleeper's last look sees the bit, or this sees that it sleeps.
  word.fetch_or(bit);
  if (page.asleep.load() == kAsleep && page.asleep.exchange(kAwake) == kAsleep) FutexWakeOne(page.asleep);
}

}  // namespace

Bell::Bell(Patience patience)
    : patience_(patience), page_([this]() -> BellPage& {
        Segment segment = MakeSegment("hgros-bell", sizeof(BellPage), Access::kEverybody, Pages::kAtOnce);
        if (!segment.mapping) throw Error("There is no shared memory: " + segment.fault + ".");
        handle_ = std::make_shared<const Handle>(std::move(segment.handle));
        mapping_ = std::move(segment.mapping);
        auto* page = new (mapping_->bytes().data()) BellPage{};
        page->magic = kBellMagic;
        page->version = kLayoutVersion;
        return *page;
      }()) {}

bool Bell::Rung() const noexcept {
  if (woken_.load()) return true;
  return std::ranges::any_of(page_.ready, [](const Shared64& word) { return word.load() != 0; });
}

bool Bell::Spin() const noexcept {
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

void Bell::Wait() noexcept {
  if (patience_.busy || patience_.spin.count() > 0) {
    if (!spinning_.exchange(true)) {
      page_.asleep.store(kAwake);
      const bool rung = Spin();
      spinning_.store(false);
      if (rung) {
        woken_.store(false);
        return;
      }
    } else {
      const std::uint32_t seen = page_.asleep.load();
      if (!woken_.exchange(false)) FutexWait(page_.asleep, seen);
      return;
    }
  }
  page_.asleep.store(kAsleep);
  if (Rung()) {
    page_.asleep.store(kAwake);
  } else {
    FutexWait(page_.asleep, kAsleep);
  }
  woken_.store(false);
}

void Bell::Ring(std::uint32_t number) noexcept { RingPage(page_, number); }

void Bell::Wake() noexcept {
  woken_.store(true);
  // Another value each time: whoever has read the word and is about to sleep on it does not.
  page_.asleep.store(page_.asleep.load() == kWoken ? kWokenAgain : kWoken);
  FutexWakeOne(page_.asleep);
}

void Bell::PassOn() noexcept {
  if (spinning_.load()) return;
  page_.asleep.store(kAsleep);
  if (Rung() && page_.asleep.exchange(kAwake) == kAsleep) FutexWakeOne(page_.asleep);
}

std::unique_ptr<PeerBell> PeerBell::Open(const Handle& handle, std::uint32_t number, std::string& fault) {
  if (number >= kMaxPeers) {
    fault = "the number " + std::to_string(number) + " is more than a bell has";
    return nullptr;
  }
  auto mapping = MapForeign(handle, sizeof(BellPage), true, fault);
  if (!mapping) return nullptr;
  const auto& page = mapping->as<BellPage>();
  if (page.magic != kBellMagic || page.version != kLayoutVersion) {
    fault = "it is no bell of this layout";
    return nullptr;
  }
  return std::make_unique<PeerBell>(std::move(mapping), number);
}

void PeerBell::Ring() const noexcept { RingPage(mapping_->as<BellPage>(), number_); }

}  // namespace hgros::shm
