#pragma once

#include <urdf_model/model.h>

#include <memory>
#include <string>

namespace hgros::viewer {

/// The model that a URDF describes, or null. Links whose joints form a ring own each other, so the last owner of the
/// model breaks the ring.
[[nodiscard]] std::shared_ptr<const urdf::ModelInterface> ReadRobotModel(const std::string& urdf);

}  // namespace hgros::viewer
