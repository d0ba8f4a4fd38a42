#include "hgros/graph/ready_node_slot.hpp"

#include <utility>

#include "graph/nodes/tbb_executor.hpp"
#include "hgros/base/thread_local.hpp"

namespace hgros {
namespace {

HGROS_THREAD_LOCAL ReadyNodeSlot* open_slot = nullptr;  // Keeps the next node that becomes ready.
HGROS_THREAD_LOCAL ReadyNodeSlot* current_slot =
    nullptr;  // The thread's slot, open or not, until it runs what it kept.

}  // namespace

ReadyNodeSlot::ReadyNodeSlot(bool open) noexcept : outer_(std::exchange(current_slot, this)) {
  if (open && open_slot == nullptr) open_slot = this;
}

ReadyNodeSlot::~ReadyNodeSlot() {
  if (open_slot == this) open_slot = nullptr;
  if (current_slot == this) current_slot = outer_;
  HandToWorkers();
}

ReadyNodeSlot::Opened::Opened() noexcept : slot_(open_slot == nullptr ? current_slot : nullptr) {
  if (slot_ != nullptr) open_slot = slot_;
}

ReadyNodeSlot::Opened::~Opened() {
  if (slot_ != nullptr && open_slot == slot_) open_slot = nullptr;
}

bool ReadyNodeSlot::TryKeep(const std::shared_ptr<Activation>& ready,
                            const std::shared_ptr<std::atomic<bool>>& taken) noexcept {
  if (open_slot == nullptr || open_slot->kept_ || taken->exchange(true, std::memory_order_acquire)) return false;
  open_slot->kept_ = ready;
  open_slot->taken_ = taken;
  return true;
}

void ReadyNodeSlot::HandToWorkers() noexcept {
  if (!kept_) return;
  const auto kept = std::exchange(kept_, nullptr);
  taken_->store(false, std::memory_order_release);
  kept->HandToWorkers();
}

void ReadyNodeSlot::RunKept() noexcept {
  if (open_slot == this) open_slot = nullptr;  // Nodes that the callbacks make ready go to the workers.
  if (current_slot == this) current_slot = nullptr;
  if (!kept_) return;
  std::exchange(kept_, nullptr)->Activate();
  taken_->store(false, std::memory_order_release);
}

}  // namespace hgros
