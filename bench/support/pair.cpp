#include "support/pair.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <thread>

namespace hgros::bench {

std::string MemoryFile() {
  const int file = memfd_create("hgros_bench", MFD_CLOEXEC);
  if (file < 0) {
    std::perror("a file in memory");
    std::exit(2);
  }
  return "/proc/" + std::to_string(getpid()) + "/fd/" + std::to_string(file);
}

PairControl* OpenControl(const std::string& path) {
  const int file = open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (file < 0 || ftruncate(file, sizeof(PairControl)) != 0) {
    std::perror(("the control file " + path).c_str());
    std::exit(2);
  }
  void* memory = mmap(nullptr, sizeof(PairControl), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  close(file);
  if (memory == MAP_FAILED) {
    std::perror("mapping the control file");
    std::exit(2);
  }
  return static_cast<PairControl*>(memory);  // A new file is all zeroes: the initial state.
}

void NoteArrival(PairControl& control, Bytes bytes) {
  Stamp stamp{};
  if (bytes.size() < sizeof stamp) return;
  std::memcpy(&stamp, bytes.data(), sizeof stamp);
  const auto last = static_cast<volatile const std::byte*>(bytes.data())[bytes.size() - 1];
  const std::int64_t now = MonotonicNow();
  (void)last;
  control.latency_ns[stamp.index % PairControl::kSlots].store(now - stamp.sent_ns, std::memory_order_relaxed);
  control.last_arrival_ns.store(now, std::memory_order_relaxed);
  control.received.fetch_add(1, std::memory_order_release);
}

BlockPool::BlockPool(std::size_t size_bytes, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    auto block = std::make_shared<Block>(Block::Allocate(size_bytes));
    std::memset(block->writable().data(), static_cast<int>(i), size_bytes);
    blocks_.push_back(std::move(block));
  }
}

const std::shared_ptr<Block>& BlockPool::Stamped(std::uint64_t index) {
  const std::shared_ptr<Block>& block = blocks_[next_];
  next_ = (next_ + 1) % blocks_.size();
  const Stamp stamp{MonotonicNow(), index};
  std::memcpy(const_cast<std::byte*>(block->bytes().data()), &stamp, sizeof stamp);
  return block;
}

Samples MeasurePair(PairControl& control, PairSender& sender, BlockPool& pool, int count, int pause_us) {
  const std::uint64_t before = control.received.load(std::memory_order_acquire);
  for (int i = 0; i < count; ++i) control.latency_ns[static_cast<std::size_t>(i)] = 0;
  for (int i = 0; i < count; ++i) {
    std::this_thread::sleep_for(std::chrono::microseconds(pause_us));
    sender.Send(pool.Stamped(static_cast<std::uint64_t>(i)));
  }
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(2);
  while (control.received.load(std::memory_order_acquire) < before + static_cast<std::uint64_t>(count) &&
         std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  Samples samples;
  for (int i = 0; i < count; ++i) {
    const std::int64_t latency = control.latency_ns[static_cast<std::size_t>(i)];
    if (latency > 0) samples.Add(static_cast<double>(latency));
  }
  return samples;
}

double FloodPair(PairControl& control, PairSender& sender, BlockPool& pool, int count) {
  const std::uint64_t before = control.received.load(std::memory_order_acquire);
  const std::int64_t start = MonotonicNow();
  for (int i = 0; i < count; ++i) sender.Send(pool.Stamped(static_cast<std::uint64_t>(i)));
  std::uint64_t seen = before;
  auto progress = std::chrono::steady_clock::now();
  for (;;) {
    const std::uint64_t received = control.received.load(std::memory_order_acquire);
    if (received >= before + static_cast<std::uint64_t>(count)) break;
    if (received != seen) {
      seen = received;
      progress = std::chrono::steady_clock::now();
    } else if (std::chrono::steady_clock::now() - progress > std::chrono::seconds(2)) {
      break;
    }
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  const auto received = static_cast<double>(control.received.load(std::memory_order_acquire) - before);
  return received / (static_cast<double>(control.last_arrival_ns.load() - start) / 1e9);
}

std::string SizeName(std::size_t size_bytes) {
  return size_bytes >= 1024 * 1024 ? std::to_string(size_bytes / (1024 * 1024)) + "MB"
                                   : std::to_string(size_bytes / 1024) + "KB";
}

}  // namespace hgros::bench
