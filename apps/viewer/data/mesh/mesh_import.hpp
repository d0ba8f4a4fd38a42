#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "viewer/data/shapes/scene_shapes.hpp"

namespace hgros::viewer {

/// Adds the triangles of a mesh file in a format that Assimp knows (Collada, OBJ, PLY, glTF ...), in meters, with the
/// file's own axes and the colors of its materials. Textures are not read. Assimp is loaded on the first call, so that
/// it does not slow down the start. Returns what is wrong, as a sentence, or nothing.
[[nodiscard]] std::string ImportMesh(const std::filesystem::path& path, std::vector<TriangleCorner>& corners);

}  // namespace hgros::viewer
