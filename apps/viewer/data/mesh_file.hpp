#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "viewer/data/scene_shapes.hpp"

namespace hgros::viewer {

/// Adds the triangles of a mesh file, three corners each, in the file's unit and axes; a colour without alpha is none.
/// Reads STL by itself, and what else Assimp reads where that is installed. Returns what is wrong, in a sentence, or
/// nothing.
[[nodiscard]] std::string ReadMesh(const std::filesystem::path& path, std::vector<TriangleCorner>& corners);

}  // namespace hgros::viewer
