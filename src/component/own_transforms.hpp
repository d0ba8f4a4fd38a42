#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "hgros/tf/transforms.hpp"

namespace hgros {

// The transforms of one component, of those that all components of the session share. Made when it first uses them.
//
// Thread safety: all functions.
class OwnTransforms {
 public:
  explicit OwnTransforms(std::function<Transforms&()> shared) : shared_(std::move(shared)) {}
  OwnTransforms(const OwnTransforms&) = delete;
  OwnTransforms& operator=(const OwnTransforms&) = delete;

  [[nodiscard]] Transforms& Get();
  // What a constructor sets, the one in another place sets as well.
  void SetConstructing(bool constructing);

  // For moves. Static edges are withdrawn, and from now on they wait. Returns whether there were some.
  bool Withhold();
  // Those that wait, except for those of the constructor.
  [[nodiscard]] std::vector<StampedEdge> Withheld() const;
  void Release();

 private:
  const std::function<Transforms&()> shared_;
  mutable std::mutex mutex_;
  std::unique_ptr<Transforms> own_;
  bool constructing_ = false;
  bool withholds_ = false;
};

}  // namespace hgros
