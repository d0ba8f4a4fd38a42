#include "viewer/data/mesh/model_meshes.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <utility>

#include "hgros/base/bytes.hpp"
#include "viewer/data/mesh/mesh_file.hpp"
#include "viewer/data/mesh/mesh_place.hpp"
#include "viewer/data/mesh/stl_mesh.hpp"
#include "viewer/data/shapes/shape_distance.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kMostCorners = 12'000'000;  ///< For all models together.
constexpr Rgba kPlain = MakeRgba(190, 190, 190);

std::string KeyOf(const SceneModel& model) {
  if (!model.url.empty()) return model.url;
  return "data " + std::to_string(model.data.size()) + " " + std::to_string(std::hash<std::string>()(model.data));
}

/// Places a point of the mesh where the model is.
Eigen::Vector3d Placed(const SceneModel& model, const Eigen::Vector3d& at) {
  return model.pose.leftCols<3>() * at + model.pose.col(3);
}

Rgba ColorOf(const SceneModel& model, const TriangleCorner& corner) {
  if (model.override_color) return model.color;
  if (AlphaOf(corner.color) > 0) return corner.color;
  return AlphaOf(model.color) > 0 ? model.color : kPlain;
}

/// Returns what is wrong, as a sentence, or nothing.
std::string ReadCorners(const SceneModel& model, std::vector<TriangleCorner>& corners) {
  std::string fault;
  if (!model.url.empty()) {
    const std::filesystem::path path = FindMesh(model.url, MeshFolders({}), fault);
    return fault.empty() ? ReadMesh(path, corners) : fault;
  }
  if (model.media_type.find("stl") == std::string::npos) {
    return "A model inside a message must be STL; this one is \"" + model.media_type + "\".";
  }
  std::vector<Eigen::Vector3f> read;
  fault = ReadStl(AsBytes(model.data), read);
  for (const Eigen::Vector3f& corner : read) corners.push_back({corner.cast<double>(), 0});
  return fault;
}

}  // namespace

ModelMeshes::Mesh ModelMeshes::Read(const SceneModel& model) {
  Mesh mesh;
  mesh.fault = ReadCorners(model, mesh.corners);
  for (const TriangleCorner& corner : mesh.corners) mesh.box.extend(corner.position);
  return mesh;
}

std::string ModelMeshes::AddTo(SceneShapes& shapes) {
  std::string first_fault;
  std::map<std::string, Mesh> used;
  for (const SceneModel& model : shapes.models) {
    const std::string key = KeyOf(model);
    auto found = used.find(key);
    if (found == used.end()) {
      auto known = meshes_.extract(key);
      found = known.empty() ? used.emplace(key, Read(model)).first : used.insert(std::move(known)).position;
    }
    const Mesh& mesh = found->second;
    std::string fault = mesh.fault;
    if (fault.empty() && shapes.triangles.size() + mesh.corners.size() > kMostCorners) {
      fault = "The models have more than " + std::to_string(kMostCorners / 3) + " triangles: the rest is left out.";
    }
    if (!fault.empty()) {
      if (first_fault.empty()) first_fault = std::move(fault);
      continue;
    }
    for (const TriangleCorner& corner : mesh.corners) {
      shapes.triangles.push_back({Placed(model, corner.position), ColorOf(model, corner)});
    }
  }
  meshes_ = std::move(used);
  return first_fault;
}

double ModelMeshes::DistanceTo(const std::vector<SceneModel>& models, const Eigen::Vector3d& at,
                               double within_m) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const SceneModel& model : models) {
    if (model.override_color && AlphaOf(model.color) == 0) continue;
    const auto found = meshes_.find(KeyOf(model));
    if (found == meshes_.end() || found->second.box.isEmpty()) continue;
    Eigen::AlignedBox3d box;
    for (int i = 0; i < 8; ++i) {
      box.extend(Placed(model, found->second.box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i))));
    }
    if (box.exteriorDistance(at) > within_m) continue;
    const std::vector<TriangleCorner>& corners = found->second.corners;
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
      const auto corner = [&](std::size_t of) { return Placed(model, corners[i + of].position); };
      nearest = std::min(nearest, DistanceToTriangle(at, corner(0), corner(1), corner(2)));
    }
  }
  return nearest <= within_m ? nearest : std::numeric_limits<double>::infinity();
}

}  // namespace hgros::viewer
