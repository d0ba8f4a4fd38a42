// hgros/StaticTransform: a component that sends the pose of one frame in another, which never changes.
#include <string>

#include "hgros/component/component.hpp"
#include "hgros/tf/transforms.hpp"

namespace hgros {
namespace {

class StaticTransform {
 public:
  explicit StaticTransform(Context& context)
      : context_(context),
        transforms_(context.transforms()),
        parent_(Frame("parent", "The frame in which the pose is given.")),
        child_(Frame("child", "The frame whose pose it is.")),
        pose_(RigidTransform::FromYawPitchRoll({Number("x", "m"), Number("y", "m"), Number("z", "m")},
                                               Number("yaw", "rad"), Number("pitch", "rad"), Number("roll", "rad"))) {}

  void Activate() {
    const SetResult set = transforms_.ToStaticTF(parent_, child_, pose_);
    if (!set) context_.Fail(set.text());
  }

 private:
  std::string Frame(const char* param, const char* description) {
    return context_.Declare(param, "", {.description = description, .read_only = true});
  }
  double Number(const char* param, const char* unit) {
    return context_.Declare(param, 0.0, {.unit = unit, .read_only = true});
  }

  Context& context_;
  Transforms& transforms_;
  const std::string parent_;
  const std::string child_;
  const RigidTransform pose_;
};

}  // namespace
}  // namespace hgros

HGROS_COMPONENT(hgros::StaticTransform, "hgros/StaticTransform")
