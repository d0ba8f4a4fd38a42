#pragma once

#include <string>

#include "hgros/Shapes.pb.h"
#include "viewer/data/shapes/scene_shapes.hpp"

namespace hgros::viewer {

/// Adds a shape, in the message's frame, to `shapes`. Returns what is wrong, as a sentence, or nothing. After an error,
/// nothing is added.
[[nodiscard]] std::string ReadShape(const hgros::Shape& shape, SceneShapes& shapes);

}  // namespace hgros::viewer
