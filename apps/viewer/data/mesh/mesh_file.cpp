#include "viewer/data/mesh/mesh_file.hpp"

#include <algorithm>
#include <cctype>

#include "hgros/base/bytes.hpp"
#include "viewer/data/mesh/mesh_import.hpp"
#include "viewer/data/mesh/stl_mesh.hpp"
#include "viewer/data/whole_file.hpp"

namespace hgros::viewer {

std::string ReadMesh(const std::filesystem::path& path, std::vector<TriangleCorner>& corners) {
  std::string ending = path.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char letter) { return std::tolower(letter); });
  if (ending != ".stl") return ImportMesh(path, corners);
  const auto bytes = ReadWholeFile(path);
  if (!bytes) return "The mesh " + path.string() + " is not a file that can be read.";
  std::vector<Eigen::Vector3f> read;
  if (std::string fault = ReadStl(AsBytes(*bytes), read); !fault.empty()) return path.string() + ": " + fault;
  for (const Eigen::Vector3f& corner : read) corners.push_back({corner.cast<double>(), 0});
  return {};
}

}  // namespace hgros::viewer
