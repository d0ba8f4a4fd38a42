// The floor through shared memory: one copy into a ring that both processes map, and a futex that wakes the receiver.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <new>

#include "buffers.hpp"
#include "peer.hpp"
#include "receiving_thread.hpp"

namespace hgros::bench {
namespace {

constexpr std::int64_t kLookNs = 50'000'000;

/// The mapped file: two counters and the slots.
class Ring {
 public:
  Ring(const Lane& lane, const std::string& folder)
      : path_(folder + "/" + lane.name + ".ring"),
        slot_bytes_(lane.size_bytes),
        slots_(static_cast<std::uint32_t>(std::min<std::size_t>(lane.depth(), 16))) {
    const int file = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (file < 0 || ftruncate(file, static_cast<off_t>(bytes())) != 0) Fail("the ring cannot be created");
    memory_ = mmap(nullptr, bytes(), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file, 0);
    close(file);
    if (memory_ == MAP_FAILED) Fail("the ring cannot be mapped");
  }
  Ring(const Ring&) = delete;
  Ring& operator=(const Ring&) = delete;
  ~Ring() {
    munmap(memory_, bytes());
    unlink(path_.c_str());
  }
  SharedCounter& written() { return static_cast<SharedCounter*>(memory_)[0]; }
  SharedCounter& read() { return static_cast<SharedCounter*>(memory_)[kCountersApart]; }
  std::byte* Slot(std::uint32_t number) {
    return static_cast<std::byte*>(memory_) + kHeaderBytes + (number % slots_) * slot_bytes_;
  }
  [[nodiscard]] std::uint32_t slots() const { return slots_; }

 private:
  static constexpr std::size_t kHeaderBytes = 4096;
  static constexpr std::size_t kCountersApart = 128 / sizeof(SharedCounter);
  [[nodiscard]] std::size_t bytes() const { return kHeaderBytes + slots_ * slot_bytes_; }

  std::string path_;
  std::size_t slot_bytes_;
  std::uint32_t slots_;
  void* memory_ = nullptr;
};

class RingInlet final : public Inlet {
 public:
  RingInlet(const Lane& lane, const std::string& folder, Sink& sink)
      : ring_(lane, folder), thread_([this, &lane, &sink](const std::atomic<bool>& stopped) {
          for (std::uint32_t number = 0; !stopped.load();) {
            if (!ring_.written().AwaitAtLeast(number + 1, kLookNs)) continue;
            sink.Note(ring_.Slot(number), lane.size_bytes);
            ring_.read().Add(1);
            ++number;
          }
        }) {}

 private:
  Ring ring_;
  ReceivingThread thread_;
};

class RingOutlet final : public Outlet {
 public:
  RingOutlet(const Lane& lane, const std::string& folder)
      : ring_(lane, folder), message_(FilledBuffer(lane.size_bytes)) {}
  std::byte* Take() override { return message_.data(); }
  bool Publish() override {
    if (number_ >= ring_.slots() && !ring_.read().AwaitAtLeast(number_ - ring_.slots() + 1, kLookNs)) return false;
    std::memcpy(ring_.Slot(number_), message_.data(), message_.size());
    ++number_;
    ring_.written().Add(1);
    return true;
  }

 private:
  Ring ring_;
  std::vector<std::byte> message_;
  std::uint32_t number_ = 0;
};

class RawShm final : public Peer {
 public:
  explicit RawShm(std::string folder) : folder_(std::move(folder)) {}
  std::unique_ptr<Inlet> Subscribe(const Lane& lane, Sink& sink) override {
    return std::make_unique<RingInlet>(lane, folder_, sink);
  }
  std::unique_ptr<Outlet> Publish(const Lane& lane) override { return std::make_unique<RingOutlet>(lane, folder_); }

 private:
  std::string folder_;
};

}  // namespace

std::unique_ptr<Peer> MakePeer(const Task& task) {
  if (task.mode != "futex") Fail("raw shared memory has no mode \"" + task.mode + "\"");
  return std::make_unique<RawShm>("/dev/shm");
}

}  // namespace hgros::bench
