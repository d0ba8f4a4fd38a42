#include "viewer/scene/display_types.hpp"

#include <algorithm>

namespace hgros::viewer {

std::span<const DisplayType> DisplayTypes() {
  static const std::vector<DisplayType> types = {
      CloudDisplayType(),
      ScanDisplayType(),
      GridDisplayType(),
      VoxelDisplayType(),
      SceneDisplayType(),
      ShapesDisplayType(),
      TrajectoryDisplayType(),
      PoseDisplayType(),
      OdometryDisplayType(),
      ImageDisplayType(),
      CompressedImageDisplayType(),
      RobotDisplayType(),
      FramesDisplayType(),
      GroundDisplayType(),
  };
  return types;
}

const DisplayType* DisplayTypeFor(std::string_view schema) {
  for (const DisplayType& type : DisplayTypes()) {
    if (std::ranges::find(type.schemas, schema) != type.schemas.end()) return &type;
  }
  return nullptr;
}

const DisplayType* DisplayTypeNamed(std::string_view name) {
  const auto found = std::ranges::find(DisplayTypes(), name, &DisplayType::name);
  return found == DisplayTypes().end() ? nullptr : &*found;
}

}  // namespace hgros::viewer
