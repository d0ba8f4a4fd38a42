#include "hgros/tf/default_transforms.hpp"

#include <memory>
#include <mutex>

namespace hgros {
namespace {

struct Default {
  std::mutex mutex;
  std::weak_ptr<Transforms> transforms;
};

}  // namespace

Transforms& DefaultTransforms() {
  // Never destroyed, like the default session.
  static Default& one = *new Default;
  const std::scoped_lock lock(one.mutex);
  if (const auto there = one.transforms.lock()) return *there;
  const auto made = std::make_shared<Transforms>(DefaultSession());
  KeepUntilShutdown(made);
  one.transforms = made;
  return *made;
}

}  // namespace hgros
