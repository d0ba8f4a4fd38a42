#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "viewer/scene/display.hpp"

namespace hgros::viewer {

/// A kind of display. A new one is a file that defines a function below, and a line in the table of display_types.cpp.
struct DisplayType {
  std::string name;                  ///< As people see it.
  std::vector<std::string> schemas;  ///< Of the channels that it shows; none: it needs no channel.
  std::unique_ptr<Display> (*make)(const DisplayInputs& inputs);
};

DisplayType CloudDisplayType();
DisplayType ScanDisplayType();
DisplayType TrajectoryDisplayType();
DisplayType PoseDisplayType();
DisplayType OdometryDisplayType();
DisplayType GridDisplayType();
DisplayType VoxelDisplayType();
DisplayType SceneDisplayType();
DisplayType ShapesDisplayType();
DisplayType ImageDisplayType();
DisplayType CompressedImageDisplayType();
DisplayType RobotDisplayType();
DisplayType FramesDisplayType();
DisplayType GroundDisplayType();

[[nodiscard]] std::span<const DisplayType> DisplayTypes();
/// The first that shows channels of a schema; null if there is none.
[[nodiscard]] const DisplayType* DisplayTypeFor(std::string_view schema);
[[nodiscard]] const DisplayType* DisplayTypeNamed(std::string_view name);

}  // namespace hgros::viewer
