#include "tf/tree/route.hpp"

namespace hgros::tf {
namespace {

const Frame* Climb(const Frame* frame, EdgeList& edges) {
  edges.Clear();
  while (const Frame* parent = frame->parent.load(std::memory_order_acquire)) {
    edges.Add(frame);
    frame = parent;
  }
  return frame;
}

}  // namespace

bool Route::Find(const Frame& target, const Frame& source) {
  do {
    target_root = Climb(&target, from_target);
    source_root = Climb(&source, from_source);
    // Not a root if it got a parent between the two climbs.
  } while (target_root != source_root && (target_root->parent.load(std::memory_order_acquire) != nullptr ||
                                          source_root->parent.load(std::memory_order_acquire) != nullptr));
  if (target_root != source_root) return false;
  while (!from_source.empty() && !from_target.empty() && from_source.Last() == from_target.Last()) {
    from_source.RemoveLast();
    from_target.RemoveLast();
  }
  return true;
}

}  // namespace hgros::tf
