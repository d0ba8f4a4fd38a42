#include "hgros/tf/transforms.hpp"

#include <utility>

#include "hgros/tf/transforms_parts.hpp"
#include "tf/transforms_core.hpp"

namespace hgros {

Transforms::Transforms(Session& session, const TransformsOptions& options)
    : core_(std::make_shared<Core>(session, options)) {}
Transforms::Transforms(std::shared_ptr<Core> core, std::shared_ptr<tf::EdgeSetter> setter)
    : core_(std::move(core)), setter_(std::move(setter)) {}
Transforms::~Transforms() {
  if (core_->fork.IsChild()) LeaveToParent(std::shared_ptr<const Core>(std::move(core_)));
}

SetResult Transforms::ToTF(Time stamp, std::string_view parent, std::string_view child,
                           const RigidTransform& T_parent_child) {
  const StampedEdge edge{std::string(parent), std::string(child), stamp, T_parent_child};
  return core_->SetMoving({&edge, 1});
}

SetResult Transforms::ToTF(std::span<const StampedEdge> edges) { return core_->SetMoving(edges); }

SetResult Transforms::ToStaticTF(std::string_view parent, std::string_view child,
                                 const RigidTransform& T_parent_child) {
  const StampedEdge edge{std::string(parent), std::string(child), {}, T_parent_child};
  return core_->SetStatic({&edge, 1}, setter_);
}

SetResult Transforms::ToStaticTF(std::span<const StampedEdge> edges) { return core_->SetStatic(edges, setter_); }

TransformTree& Transforms::tree() {
  core_->Listen();
  return core_->tree();
}

void Transforms::Flush() { core_->sender().Flush(); }

TransformsStats Transforms::stats() const { return core_->stats(); }

std::unique_ptr<Transforms> TransformsParts::ForComponent() const {
  return std::unique_ptr<Transforms>(new Transforms(transforms_.core_, std::make_shared<tf::EdgeSetter>()));
}

void TransformsParts::SetConstructing(bool constructing) {
  transforms_.core_->sender().SetConstructing(*transforms_.setter_, constructing);
}

bool TransformsParts::Withhold() { return transforms_.core_->Withhold(*transforms_.setter_); }

std::vector<StampedEdge> TransformsParts::Withheld() const {
  std::vector<StampedEdge> edges;
  for (auto& one : transforms_.core_->sender().Withheld(*transforms_.setter_)) {
    if (!one.by_constructor) edges.push_back(std::move(one.edge));
  }
  return edges;
}

void TransformsParts::Release() { transforms_.core_->Release(transforms_.setter_); }

}  // namespace hgros
