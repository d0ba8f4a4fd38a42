#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace hgros::viewer {

/// Where a description's meshes may lie: `package://NAME/rest` is looked for as FOLDER/NAME/rest, and as FOLDER/rest
/// where FOLDER is called NAME; other names relative to each folder. First those given, then the folders of the
/// environment variables HGROS_MESH_PATH and ROS_PACKAGE_PATH.
[[nodiscard]] std::vector<std::filesystem::path> MeshFolders(std::vector<std::filesystem::path> given);

/// The file that `name` ("package://...", "file://...", a path) stands for; empty if there is none, and `fault` then
/// says where it was looked for, in a sentence. No name leads out of the folder that it is looked for in.
[[nodiscard]] std::filesystem::path FindMesh(std::string_view name, const std::vector<std::filesystem::path>& folders,
                                             std::string& fault);

}  // namespace hgros::viewer
