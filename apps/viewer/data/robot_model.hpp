#pragma once

#include <urdf_model/model.h>

#include <memory>
#include <string>

namespace hgros::viewer {

/// The model that a URDF describes; null if it describes none. Links whose joints make a ring hold each other, so
/// whoever has the model last unties them.
[[nodiscard]] std::shared_ptr<const urdf::ModelInterface> ReadRobotModel(const std::string& urdf);

}  // namespace hgros::viewer
