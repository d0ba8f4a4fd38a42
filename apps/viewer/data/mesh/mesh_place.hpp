#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace hgros::viewer {

/// The folders that are searched for meshes. `package://NAME/rest` is searched as FOLDER/NAME/rest, and as FOLDER/rest
/// if FOLDER is called NAME. Other names are relative to each folder. The given folders come first, then those of the
/// environment variables HGROS_MESH_PATH and ROS_PACKAGE_PATH.
[[nodiscard]] std::vector<std::filesystem::path> MeshFolders(std::vector<std::filesystem::path> given);

/// Finds the file for `name` ("package://...", "file://...", or a path). Empty if there is none; then `fault` is a
/// sentence that says where it was searched. A name cannot lead out of the searched folder.
[[nodiscard]] std::filesystem::path FindMesh(std::string_view name, const std::vector<std::filesystem::path>& folders,
                                             std::string& fault);

}  // namespace hgros::viewer
