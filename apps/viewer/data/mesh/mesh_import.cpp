#include "viewer/data/mesh/mesh_import.hpp"

#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>

namespace hgros::viewer {
namespace {

constexpr const char* kLibrary = "libassimp.so.5";

/// The functions of Assimp that are used here. The library stays loaded.
struct Assimp {
  decltype(&aiImportFileExWithProperties) load = nullptr;
  decltype(&aiReleaseImport) release = nullptr;
  decltype(&aiGetErrorString) error = nullptr;
  decltype(&aiCreatePropertyStore) make_properties = nullptr;
  decltype(&aiReleasePropertyStore) release_properties = nullptr;
  decltype(&aiSetImportPropertyInteger) set_integer = nullptr;
  decltype(&aiGetMaterialColor) color = nullptr;

  Assimp() {
    void* const library = dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) return;
    const auto take = [&](auto& function, const char* name) {
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));  // NOLINT
      return function != nullptr;
    };
    complete_ = take(load, "aiImportFileExWithProperties") && take(release, "aiReleaseImport") &&
                take(error, "aiGetErrorString") && take(make_properties, "aiCreatePropertyStore") &&
                take(release_properties, "aiReleasePropertyStore") && take(set_integer, "aiSetImportPropertyInteger") &&
                take(color, "aiGetMaterialColor");
  }
  [[nodiscard]] bool complete() const noexcept { return complete_; }

 private:
  bool complete_ = false;
};

Rgba ColorOf(const Assimp& assimp, const aiMaterial* material) {
  aiColor4D diffuse;
  if (material == nullptr || assimp.color(material, AI_MATKEY_COLOR_DIFFUSE, &diffuse) != AI_SUCCESS) return 0;
  const auto byte = [](float part) {
    return std::isfinite(part) ? static_cast<unsigned>(std::lround(std::clamp(part, 0.0F, 1.0F) * 255)) : 0U;
  };
  // Some exporters write transparency inverted. Robots are opaque.
  return MakeRgba(byte(diffuse.r), byte(diffuse.g), byte(diffuse.b));
}

}  // namespace

std::string ImportMesh(const std::filesystem::path& path, std::vector<TriangleCorner>& corners) {
  static const Assimp assimp;
  if (!assimp.complete()) {
    return "Reading " + path.string() + " needs " + kLibrary + ", which Debian's package libassimp5 installs.";
  }
  const std::unique_ptr<aiPropertyStore, void (*)(aiPropertyStore*)> properties(assimp.make_properties(),
                                                                                assimp.release_properties);
  // Robot descriptions expect this: the axes of the file are the axes of the link.
  assimp.set_integer(properties.get(), AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, 1);
  assimp.set_integer(properties.get(), AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const std::unique_ptr<const aiScene, void (*)(const aiScene*)> scene(
      assimp.load(path.c_str(), aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices, nullptr,
                  properties.get()),
      assimp.release);
  if (!scene) return "The mesh " + path.string() + " cannot be read: " + assimp.error() + ".";
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    const Rgba color =
        ColorOf(assimp, mesh.mMaterialIndex < scene->mNumMaterials ? scene->mMaterials[mesh.mMaterialIndex] : nullptr);
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;
      for (unsigned i = 0; i < 3; ++i) {
        const aiVector3D& at = mesh.mVertices[face.mIndices[i]];
        corners.push_back({Eigen::Vector3d(at.x, at.y, at.z), color});
      }
    }
  }
  return {};
}

}  // namespace hgros::viewer
