#include "control.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>

#include "stamp.hpp"

namespace hgros::bench {
namespace {

void KeepLarger(std::atomic<std::int64_t>& largest, std::int64_t value) {
  std::int64_t seen = largest.load(std::memory_order_relaxed);
  while (seen < value && !largest.compare_exchange_weak(seen, value, std::memory_order_release)) {
  }
}

}  // namespace

Control& OpenControl(const Task& task) {
  int file = -1;
  if (!task.control.empty()) {
    file = open(task.control.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (file < 0 || ftruncate(file, sizeof(Control)) != 0) Fail("the control file cannot be created");
  }
  void* memory = mmap(nullptr, sizeof(Control), PROT_READ | PROT_WRITE,
                      file < 0 ? MAP_SHARED | MAP_ANONYMOUS : MAP_SHARED, file, 0);
  if (file >= 0) close(file);
  if (memory == MAP_FAILED) Fail("the control file cannot be mapped");
  return *static_cast<Control*>(memory);
}

void Sink::Note(const void* bytes, std::size_t size_bytes) {
  if (size_bytes != lane_.size_bytes) {
    control_.damaged.fetch_add(1);
    return;
  }
  const auto* readable = static_cast<const volatile unsigned char*>(bytes);
  const unsigned char last = readable[size_bytes - 1];
  Stamp stamp{};
  std::memcpy(&stamp, bytes, sizeof stamp);
  const std::int64_t now = NowNs();
  if (stamp.lane != lane_.index || last != static_cast<unsigned char>(stamp.index)) {
    control_.damaged.fetch_add(1);
    return;
  }
  switch (stamp.phase) {
    case Phase::kProbe:
      if (!probed_) control_.probed.Add(1);
      probed_ = true;
      break;
    case Phase::kTimed:
      KeepLarger(control_.latency_ns[stamp.index % Control::kTimed], now - stamp.sent_ns);
      control_.timed.Add(1);
      break;
    case Phase::kFlood:
      control_.last_flooded_ns.store(now, std::memory_order_relaxed);
      control_.flooded.fetch_add(1, std::memory_order_release);
      break;
  }
}

}  // namespace hgros::bench
