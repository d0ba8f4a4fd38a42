#include "hgros/c/transforms.h"

#include "c/handles.hpp"
#include "hgros/tf/transforms.hpp"

struct hgros_transforms {
  std::shared_ptr<hgros::c::Life> life;
  std::shared_ptr<hgros::c::Held<hgros::Transforms>> held;
};

namespace hgros::c {
namespace {

RigidTransform PoseFrom(const hgros_transform& given) {
  const double* const turn = static_cast<const double*>(given.rotation);
  return {RigidTransform::Rotation(turn[3], turn[0], turn[1], turn[2]),
          {given.translation[0], given.translation[1], given.translation[2]}};
}

hgros_transform PoseTo(const StampedTransform& found) {
  const RigidTransform& pose = found.T_target_source;
  return {{pose.translation.x(), pose.translation.y(), pose.translation.z()},
          {pose.rotation.x(), pose.rotation.y(), pose.rotation.z(), pose.rotation.w()},
          found.stamp.nanoseconds};
}

hgros_status StatusOf(TransformFault fault) noexcept {
  switch (fault) {
    case TransformFault::kNone: return HGROS_OK;
    case TransformFault::kUnknownFrame: return HGROS_UNKNOWN_FRAME;
    case TransformFault::kNotConnected: return HGROS_NOT_CONNECTED;
    case TransformFault::kTooOld: return HGROS_TOO_OLD;
    case TransformFault::kTooNew: return HGROS_TOO_NEW;
    case TransformFault::kTimeout: return HGROS_TIMED_OUT;
    case TransformFault::kStopped: return HGROS_CLOSED;
  }
  return HGROS_ERROR;
}

hgros_status SetDone(const SetResult& result) {
  return result ? hgros_status{HGROS_OK} : Fail(HGROS_REFUSED, result.text());
}

template <class F>
hgros_status UseTransforms(hgros_transforms* transforms, F&& use) {
  return Guarded([&] {
    const auto held = Given(transforms, "transforms").held;  // The handle may be closed while a wait ends.
    return held->Use(use);
  });
}

// `look` returns the result of a lookup.
template <class F>
hgros_status Find(hgros_transforms* transforms, hgros_transform* found, F&& look) {
  if (found != nullptr) *found = {};
  return UseTransforms(transforms, [&](Transforms& of) {
    hgros_transform& place = Given(found, "the place for the result");
    const TransformResult result = look(of);
    if (!result) return Fail(StatusOf(result.fault()), result.text());
    place = PoseTo(*result);
    return hgros_status{HGROS_OK};
  });
}

}  // namespace
}  // namespace hgros::c

namespace c = hgros::c;

hgros_status hgros_transforms_open(hgros_session* session, hgros_transforms** transforms) {
  return c::Creating(transforms, [&] {
    const hgros_session& on = c::Opened(session);
    auto held = std::make_shared<c::Held<hgros::Transforms>>(std::make_unique<hgros::Transforms>(*on.session));
    on.life->Add(held);
    return std::make_unique<hgros_transforms>(hgros_transforms{on.life, std::move(held)});
  });
}

hgros_status hgros_transforms_close(hgros_transforms* transforms) {
  if (transforms == nullptr) return HGROS_OK;
  return c::Closing(transforms->life.get(), *transforms->held, [&] { delete transforms; });
}

hgros_status hgros_transforms_set(hgros_transforms* transforms, const char* parent, const char* child,
                                  const hgros_transform* pose) {
  return c::UseTransforms(transforms, [&](hgros::Transforms& of) {
    const hgros_transform& given = c::Given(pose, "pose");
    return c::SetDone(
        of.ToTF(hgros::Time{given.stamp_ns}, c::Text(parent, "parent"), c::Text(child, "child"), c::PoseFrom(given)));
  });
}

hgros_status hgros_transforms_set_static(hgros_transforms* transforms, const char* parent, const char* child,
                                         const hgros_transform* pose) {
  return c::UseTransforms(transforms, [&](hgros::Transforms& of) {
    return c::SetDone(
        of.ToStaticTF(c::Text(parent, "parent"), c::Text(child, "child"), c::PoseFrom(c::Given(pose, "pose"))));
  });
}

hgros_status hgros_transforms_lookup(hgros_transforms* transforms, const char* target, const char* source,
                                     hgros_transform* found) {
  return c::Find(transforms, found, [&](hgros::Transforms& of) {
    return of.FromTF(c::Text(target, "target"), c::Text(source, "source"));
  });
}

hgros_status hgros_transforms_lookup_at(hgros_transforms* transforms, const char* target, const char* source,
                                        int64_t time_ns, hgros_transform* found) {
  return c::Find(transforms, found, [&](hgros::Transforms& of) {
    return of.FromTF(c::Text(target, "target"), c::Text(source, "source"), hgros::Time{time_ns});
  });
}

hgros_status hgros_transforms_wait(hgros_transforms* transforms, const char* target, const char* source,
                                   int64_t time_ns, int64_t timeout_ns, hgros_transform* found) {
  return c::Find(transforms, found, [&](hgros::Transforms& of) {
    hgros::TransformTree& tree = of.tree();
    const hgros::TransformQuery query(tree.Frame(c::Text(target, "target")), tree.Frame(c::Text(source, "source")),
                                      hgros::Time{time_ns});
    return tree.Wait(query, c::Timeout(timeout_ns), transforms->held->stop());
  });
}
