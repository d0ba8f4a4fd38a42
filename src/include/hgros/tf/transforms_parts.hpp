#pragma once

#include <memory>
#include <vector>

#include "hgros/tf/transforms.hpp"

namespace hgros {

// For components, each of which has a Transforms that knows which static edges it has set.
//
// Thread safety: all functions.
class TransformsParts {
 public:
  explicit TransformsParts(Transforms& transforms) : transforms_(transforms) {}

  // With the tree, channels and statistics of this one, which it may outlive, but not the session.
  [[nodiscard]] std::unique_ptr<Transforms> ForComponent() const;

  // The rest is for those of components.

  // Whether static edges are now set by the constructor, which sets them in each place.
  void SetConstructing(bool constructing);
  // From now on its static edges are not sent, as if it had never set them. Returns whether some were sent before.
  bool Withhold();
  // Static edges that are not sent, in the order in which they were set. Without those that the constructor has set.
  [[nodiscard]] std::vector<StampedEdge> Withheld() const;
  // Sends them.
  void Release();

 private:
  Transforms& transforms_;
};

}  // namespace hgros
