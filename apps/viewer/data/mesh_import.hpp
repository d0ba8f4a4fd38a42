#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "viewer/data/scene_shapes.hpp"

namespace hgros::viewer {

/// Adds the triangles of a mesh file of a format that Assimp knows (Collada, OBJ, PLY, glTF ...), in metres and with
/// the file's own axes, coloured by its materials; textures are not read. Assimp is loaded when it is first asked for:
/// no other program start pays for it. Returns what is wrong, in a sentence, or nothing.
[[nodiscard]] std::string ImportMesh(const std::filesystem::path& path, std::vector<TriangleCorner>& corners);

}  // namespace hgros::viewer
