#include "component/input_gates.hpp"

#include <algorithm>

namespace hgros {

InputGates::Asked InputGates::Ask(InputWiring wiring, AnyCallback callback, std::shared_ptr<ComponentGuard> guard) {
  Asked asked;
  const std::scoped_lock lock(mutex_);
  const auto found =
      std::ranges::find_if(gates_, [&](const Lasting& one) { return !one.used && one.wiring.node == wiring.node; });
  if (found != gates_.end() && found->wiring == wiring) {
    found->used = true;
    found->gate->Replace(std::move(callback));
    return asked;
  }
  if (found != gates_.end()) {
    asked.ends = std::move(found->gate);
    gates_.erase(found);
  }
  asked.fresh = std::make_shared<InputGate>(wiring.node, *wiring.type, wiring.invoke, wiring.queue, std::move(callback),
                                            std::move(guard));
  if (again_) asked.fresh->Hold([] {}, InputGate::Full::kWaits);
  gates_.push_back({std::move(wiring), asked.fresh});
  return asked;
}

void InputGates::BeginAgain() {
  const std::scoped_lock lock(mutex_);
  again_ = true;
  for (Lasting& one : gates_) one.used = false;
}

std::vector<std::shared_ptr<InputGate>> InputGates::EndAgain() {
  const std::scoped_lock lock(mutex_);
  again_ = false;
  std::vector<std::shared_ptr<InputGate>> unused;
  for (const Lasting& one : gates_) {
    if (!one.used) unused.push_back(one.gate);
  }
  std::erase_if(gates_, [](const Lasting& one) { return !one.used; });
  return unused;
}

std::vector<std::shared_ptr<InputGate>> InputGates::all() const {
  const std::scoped_lock lock(mutex_);
  std::vector<std::shared_ptr<InputGate>> all;
  for (const Lasting& one : gates_) all.push_back(one.gate);
  return all;
}

}  // namespace hgros
