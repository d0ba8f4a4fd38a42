#pragma once

#include <string>

#include "hgros/Shapes.pb.h"
#include "viewer/data/scene_shapes.hpp"

namespace hgros::viewer {

/// Adds what a shape is drawn with, in the message's frame, to `shapes`. Returns what is wrong with it, in a sentence;
/// then nothing is added.
[[nodiscard]] std::string ReadShape(const hgros::Shape& shape, SceneShapes& shapes);

}  // namespace hgros::viewer
