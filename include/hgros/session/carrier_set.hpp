#pragma once

namespace hgros {

/// What carries messages between sessions, the cheapest first.
enum class CarrierKind { kShm, kZmq };

/// The carriers that a channel may take.
struct CarrierSet {
  bool shared_memory = true;
  bool zmq = true;

  [[nodiscard]] bool Has(CarrierKind kind) const noexcept { return kind == CarrierKind::kShm ? shared_memory : zmq; }
  [[nodiscard]] bool all() const noexcept { return shared_memory && zmq; }
  [[nodiscard]] bool none() const noexcept { return !shared_memory && !zmq; }
  [[nodiscard]] CarrierSet In(const CarrierSet& other) const noexcept {
    return {shared_memory && other.shared_memory, zmq && other.zmq};
  }
  bool operator==(const CarrierSet&) const = default;
};

}  // namespace hgros
