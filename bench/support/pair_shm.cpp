// The floor of shared memory: one ring of large slots, one futex, one copy on the way in.
#include <fcntl.h>
#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "support/pair.hpp"

namespace hgros::bench {
namespace {

constexpr std::size_t kRingSlots = 16;
constexpr std::size_t kSlotBytes = 4096 * 1024;

struct Ring {
  alignas(64) std::atomic<std::uint32_t> written{0};
  alignas(64) std::atomic<std::uint32_t> asleep{0};
  std::atomic<std::uint32_t> stop{0};
  std::size_t sizes[kRingSlots] = {};
  alignas(4096) std::byte slots[kRingSlots][kSlotBytes];
};

Ring* OpenRing(const std::string& path) {
  const int fd = open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0 || ftruncate(fd, sizeof(Ring)) != 0) {
    std::perror(path.c_str());
    std::exit(2);
  }
  void* memory = mmap(nullptr, sizeof(Ring), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, fd, 0);
  close(fd);
  if (memory == MAP_FAILED) {
    std::perror("mmap");
    std::exit(2);
  }
  return static_cast<Ring*>(memory);
}

void Futex(std::atomic<std::uint32_t>& word, int operation, std::uint32_t value) {
  syscall(SYS_futex, &word, operation, value, nullptr, nullptr, 0);
}

class ShmSender final : public PairSender {
 public:
  explicit ShmSender(const std::string& path) : ring_(*OpenRing(path)) {}
  void Send(const std::shared_ptr<Block>& block) override {
    const std::uint32_t index = ring_.written.load(std::memory_order_relaxed);
    std::memcpy(ring_.slots[index % kRingSlots], block->bytes().data(), block->size());
    ring_.sizes[index % kRingSlots] = block->size();
    ring_.written.store(index + 1);
    if (ring_.asleep.exchange(0) == 1) Futex(ring_.written, FUTEX_WAKE, 1);
  }

 private:
  Ring& ring_;
};

class ShmReceiver final : public PairReceiver {
 public:
  ShmReceiver(const std::string& path, PairControl& control) : ring_(*OpenRing(path)) {
    thread_ = std::thread([this, &control] {
      for (std::uint32_t read = ring_.written.load(); ring_.stop == 0;) {
        if (ring_.written.load() == read) {
          ring_.asleep = 1;
          if (ring_.written.load() == read) Futex(ring_.written, FUTEX_WAIT, read);
          continue;
        }
        NoteArrival(control, {ring_.slots[read % kRingSlots], ring_.sizes[read % kRingSlots]});
        ++read;
      }
    });
  }
  ~ShmReceiver() override {
    ring_.stop = 1;
    ring_.written.fetch_add(1);
    Futex(ring_.written, FUTEX_WAKE, 1);
    thread_.join();
  }

 private:
  Ring& ring_;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<PairSender> MakeShmSender(const std::string& path) { return std::make_unique<ShmSender>(path); }
std::unique_ptr<PairReceiver> MakeShmReceiver(const std::string& path, PairControl& control) {
  return std::make_unique<ShmReceiver>(path, control);
}

}  // namespace hgros::bench
