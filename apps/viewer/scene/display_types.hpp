#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "viewer/scene/display.hpp"

namespace hgros::viewer {

/// A kind of display. To add one, write a file that defines a function below, and add a line to the table in
/// display_types.cpp.
struct DisplayType {
  std::string name;                  ///< The name that users see.
  std::vector<std::string> schemas;  ///< Schemas of the channels that it shows. Empty: it needs no channel.
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
/// The first display type that shows channels of a schema; null if there is none.
[[nodiscard]] const DisplayType* DisplayTypeFor(std::string_view schema);
[[nodiscard]] const DisplayType* DisplayTypeNamed(std::string_view name);

}  // namespace hgros::viewer
