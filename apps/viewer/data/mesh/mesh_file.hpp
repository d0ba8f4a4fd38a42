#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "viewer/data/shapes/scene_shapes.hpp"

namespace hgros::viewer {

/// Adds the triangles of a mesh file, three corners each, in the file's unit and axes. A color without alpha means no
/// color. Reads STL itself, and other formats with Assimp if that is installed. Returns what is wrong, as a sentence,
/// or nothing.
[[nodiscard]] std::string ReadMesh(const std::filesystem::path& path, std::vector<TriangleCorner>& corners);

}  // namespace hgros::viewer
