// What of a component's wiring lasts while it is held, and when another instance takes its place.
#include <algorithm>
#include <utility>

#include "component/context_core.hpp"
#include "hgros/base/error.hpp"

namespace hgros {

void ContextCore::BeginAgain(ComponentSetup setup) {
  changes_ = {};  // Outside the lock: it waits for a call.
  const std::scoped_lock lock(mutex_);
  setup_ = std::move(setup);
  params_.emplace(SourcesOf(setup_), Sink());
  timers_ = services_ = Stage();
  inputs_.begun = false;
  gates_.BeginAgain();
  constructed_ = false;
  names_.clear();
  nodes_.clear();
  faulty_params_.clear();
  status_ = {setup_.name};
  ComponentDescription next;
  next.name = setup_.name;
  next.type = setup_.type;
  next.state = description_.state;
  next.fingerprints[next.state] = description_.fingerprints.at(next.state);
  description_ = std::move(next);
}

void ContextCore::EndUnused() {
  for (const auto& gate : gates_.EndAgain()) EndInput(*gate);
}

void ContextCore::EndInput(InputGate& gate) {
  gate.Close();
  Kept kept;  // Ends outside the lock: it waits for callbacks.
  const std::scoped_lock lock(mutex_);
  const auto found = std::ranges::find(inputs_.kept, gate.node(), [](const auto& one) { return one.first; });
  if (found == inputs_.kept.end()) return;
  kept = std::move(found->second);
  inputs_.kept.erase(found);
}

void ContextCore::SetPlace(Place place) {
  const std::scoped_lock lock(mutex_);
  place_ = place;
  placed_.notify_all();
}

void ContextCore::AwaitHere() {
  std::unique_lock lock(mutex_);
  placed_.wait(lock, [this] { return place_ != Place::kHeld; });
  if (place_ == Place::kElsewhere) {
    throw Error("The component \"" + setup_.name + "\" has moved to another process, is constructed again, or ends.",
                {}, "Call again.");
  }
}

}  // namespace hgros
