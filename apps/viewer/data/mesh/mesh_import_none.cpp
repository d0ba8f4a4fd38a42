#include "viewer/data/mesh/mesh_import.hpp"

namespace hgros::viewer {

// For programs that were built without Assimp's headers.
std::string ImportMesh(const std::filesystem::path& path, std::vector<TriangleCorner>& /*corners*/) {
  return "The mesh " + path.string() +
         " is not STL, and this program was built without Assimp (Debian's package libassimp-dev).";
}

}  // namespace hgros::viewer
