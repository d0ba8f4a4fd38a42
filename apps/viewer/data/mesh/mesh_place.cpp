#include "viewer/data/mesh/mesh_place.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <optional>
#include <sstream>

namespace hgros::viewer {
namespace {

namespace fs = std::filesystem;

bool LeadsOut(const fs::path& relative) {
  return relative.is_absolute() || std::ranges::find(relative, fs::path("..")) != relative.end();
}

std::optional<std::string_view> After(std::string_view scheme, std::string_view name) {
  if (!name.starts_with(scheme)) return std::nullopt;
  return name.substr(scheme.size());
}

/// The path in a URL: %20 is a space.
std::string PathOfUrl(std::string_view url) {
  std::string path;
  for (std::size_t i = 0; i < url.size(); ++i) {
    unsigned code = 0;
    const char* const digits = url.data() + i + 1;
    const bool coded =
        url[i] == '%' && i + 2 < url.size() && std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2;
    path += coded ? static_cast<char>(code) : url[i];
    i += coded ? 2 : 0;
  }
  return path;
}

bool IsFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

}  // namespace

std::vector<fs::path> MeshFolders(std::vector<fs::path> given) {
  for (const char* variable : {"HGROS_MESH_PATH", "ROS_PACKAGE_PATH"}) {
    const char* const value = std::getenv(variable);
    std::istringstream folders(value == nullptr ? "" : value);
    for (std::string folder; std::getline(folders, folder, ':');) {
      if (!folder.empty()) given.emplace_back(folder);
    }
  }
  return given;
}

fs::path FindMesh(std::string_view name, const std::vector<fs::path>& folders, std::string& fault) {
  if (const auto path = After("file://", name)) {
    fs::path file = PathOfUrl(*path);
    if (IsFile(file)) return file;
    fault = "There is no mesh " + file.string() + ".";
    return {};
  }
  std::vector<fs::path> tried;
  if (const auto rest = After("package://", name)) {
    const fs::path relative(PathOfUrl(*rest));
    if (LeadsOut(relative) || relative.empty()) {
      fault = "\"" + std::string(name) + "\" is not a valid name for a mesh.";
      return {};
    }
    const fs::path package = *relative.begin();
    for (const fs::path& folder : folders) {
      tried.push_back(folder / relative);
      const fs::path own_name = folder.has_filename() ? folder.filename() : folder.parent_path().filename();
      if (own_name == package) tried.push_back(folder / relative.lexically_relative(package));
    }
  } else if (const fs::path path(name); path.is_absolute()) {
    tried.push_back(path);
  } else if (!LeadsOut(path) && name.find("://") == std::string_view::npos) {
    for (const fs::path& folder : folders) tried.push_back(folder / path);
  }
  for (const fs::path& path : tried) {
    if (IsFile(path)) return path;
  }
  fault = "The mesh \"" + std::string(name) + "\" was not found";
  if (folders.empty()) {
    fault += ": no folder for meshes is given. HGROS_MESH_PATH can name folders.";
  } else {
    fault += " in " + folders.front().string() +
             (folders.size() > 1 ? " and " + std::to_string(folders.size() - 1) + " more folders." : ".");
  }
  return {};
}

}  // namespace hgros::viewer
