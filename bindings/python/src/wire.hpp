#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "hgros/base/bytes.hpp"
#include "of_process.hpp"

namespace hgros::python {

/// The leases that Python holds: memory of received messages that no other message can use meanwhile.
struct Leases {
  std::atomic<std::int64_t> count{0};
  std::atomic<std::int64_t> bytes{0};
};
inline Leases leases;

/// The bytes of a received message where they arrived, for Python's buffer protocol. Python owns it through memoryviews
/// and arrays; it returns the memory when the last of them is gone.
class Wire : public OfProcess {
 public:
  explicit Wire(Payload data) : data_(std::move(data)) {
    leases.count.fetch_add(1, std::memory_order_relaxed);
    leases.bytes.fetch_add(static_cast<std::int64_t>(data_.bytes.size()), std::memory_order_relaxed);
  }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;
  ~Wire() {
    leases.count.fetch_sub(1, std::memory_order_relaxed);
    leases.bytes.fetch_sub(static_cast<std::int64_t>(data_.bytes.size()), std::memory_order_relaxed);
  }

  [[nodiscard]] const Payload& data() const noexcept { return data_; }

 private:
  const Payload data_;
};

}  // namespace hgros::python
