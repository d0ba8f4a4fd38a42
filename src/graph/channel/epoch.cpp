#include "graph/channel/epoch.hpp"

#include <algorithm>
#include <limits>
#include <mutex>
#include <utility>
#include <vector>

#include "hgros/base/thread_local.hpp"

namespace hgros::epoch {
namespace {

struct Retired {
  std::shared_ptr<const void> object;
  std::uint64_t epoch;
};

// One for the process, like the heap: it holds no state that a program could observe. Never destroyed, since threads
// may end after static destructors have run.
struct Domain {
  std::atomic<std::uint64_t> current{1};
  std::atomic<Reader*> readers{nullptr};
  std::mutex mutex;
  std::vector<Retired> retired;
};

Domain& TheDomain() noexcept {
  static Domain& domain = *new Domain;
  return domain;
}

// Readers are never freed, only handed to the next thread.
Reader* TakeReader() noexcept {
  Domain& domain = TheDomain();
  for (Reader* reader = domain.readers.load(std::memory_order_acquire); reader != nullptr; reader = reader->next) {
    bool free = false;
    if (reader->taken.compare_exchange_strong(free, true, std::memory_order_acquire)) return reader;
  }
  auto* reader = new Reader;
  reader->taken.store(true, std::memory_order_relaxed);
  reader->next = domain.readers.load(std::memory_order_relaxed);
  while (!domain.readers.compare_exchange_weak(reader->next, reader, std::memory_order_release)) {
  }
  return reader;
}

// Both outlive the thread's other thread-local objects, which may still publish in their destructors.
HGROS_THREAD_LOCAL Reader* reader_here = nullptr;
HGROS_THREAD_LOCAL bool thread_ends = false;

struct Registration {
  ~Registration() {
    thread_ends = true;
    if (reader_here != nullptr) GiveBack(*reader_here);
  }
};

std::uint64_t OldestActive() noexcept {
  std::uint64_t oldest = std::numeric_limits<std::uint64_t>::max();
  for (Reader* reader = TheDomain().readers.load(std::memory_order_seq_cst); reader != nullptr; reader = reader->next) {
    const std::uint64_t active = reader->active.load(std::memory_order_seq_cst);
    if (active != 0) oldest = std::min(oldest, active);
  }
  return oldest;
}

}  // namespace

Reader& ThisThread() noexcept {
  if (reader_here == nullptr) [[unlikely]] {
    reader_here = TakeReader();
    reader_here->late = thread_ends;
    if (!thread_ends) HGROS_THREAD_LOCAL const Registration registration;
  }
  return *reader_here;
}

void GiveBack(Reader& reader) noexcept {
  reader_here = nullptr;
  reader.taken.store(false, std::memory_order_release);
}

std::uint64_t Current() noexcept {
  static std::atomic<std::uint64_t>& current = TheDomain().current;
  return current.load(std::memory_order_seq_cst);
}

void Retire(std::shared_ptr<const void> object) {
  Domain& domain = TheDomain();
  const std::uint64_t epoch = domain.current.fetch_add(1, std::memory_order_seq_cst);
  {
    const std::scoped_lock lock(domain.mutex);
    domain.retired.push_back({std::move(object), epoch});
  }
  Collect();
}

void Collect() {
  Domain& domain = TheDomain();
  std::vector<Retired> free;  // Declared before the lock and so destroyed after it: a destructor may retire more.
  const std::scoped_lock lock(domain.mutex);
  const std::uint64_t oldest = OldestActive();
  const auto kept = std::partition(domain.retired.begin(), domain.retired.end(),
                                   [oldest](const Retired& item) { return item.epoch >= oldest; });
  free.assign(std::make_move_iterator(kept), std::make_move_iterator(domain.retired.end()));
  domain.retired.erase(kept, domain.retired.end());
}

}  // namespace hgros::epoch
