#include "component/own_transforms.hpp"

#include "hgros/tf/transforms_parts.hpp"

namespace hgros {

Transforms& OwnTransforms::Get() {
  const std::scoped_lock lock(mutex_);
  if (own_) return *own_;
  auto own = TransformsParts(shared_()).ForComponent();
  TransformsParts parts(*own);
  parts.SetConstructing(constructing_);
  if (withholds_) (void)parts.Withhold();
  own_ = std::move(own);
  return *own_;
}

void OwnTransforms::SetConstructing(bool constructing) {
  const std::scoped_lock lock(mutex_);
  constructing_ = constructing;
  if (own_) TransformsParts(*own_).SetConstructing(constructing);
}

// Outside the lock: subscribers may set transforms themselves.
bool OwnTransforms::Withhold() {
  Transforms* own = nullptr;
  {
    const std::scoped_lock lock(mutex_);
    withholds_ = true;
    own = own_.get();
  }
  return own != nullptr && TransformsParts(*own).Withhold();
}

std::vector<StampedEdge> OwnTransforms::Withheld() const {
  const std::scoped_lock lock(mutex_);
  return own_ ? TransformsParts(*own_).Withheld() : std::vector<StampedEdge>();
}

void OwnTransforms::Release() {
  Transforms* own = nullptr;
  {
    const std::scoped_lock lock(mutex_);
    withholds_ = false;
    own = own_.get();
  }
  if (own != nullptr) TransformsParts(*own).Release();
}

}  // namespace hgros
