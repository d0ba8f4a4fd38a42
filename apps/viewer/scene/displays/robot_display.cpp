#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "viewer/data/mesh/mesh_file.hpp"
#include "viewer/data/mesh/mesh_place.hpp"
#include "viewer/data/quantity_text.hpp"
#include "viewer/data/robot/robot_links.hpp"
#include "viewer/data/robot/robot_shapes.hpp"
#include "viewer/data/shapes/shape_bounds.hpp"
#include "viewer/data/whole_file.hpp"
#include "viewer/scene/display_types.hpp"
#include "viewer/scene/displays/transform_wait.hpp"
#include "viewer/scene/layers/solids.hpp"
#include "viewer/scene/layers/triangles.hpp"

namespace hgros::viewer {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostNamed = 3;  ///< Largest number of faulty links or files that are named.

/// "a, b, c and 4 more"
std::string ListFirst(const std::vector<std::string>& names) {
  std::string list;
  for (std::size_t i = 0; i < std::min(names.size(), kMostNamed); ++i) list += (i > 0 ? ", " : "") + names[i];
  if (names.size() > kMostNamed) list += " and " + std::to_string(names.size() - kMostNamed) + " more";
  return list;
}

/// A robot as its URDF describes it. Each link is where its frame is now, or where its joint holds it.
class RobotDisplay : public Display {
 public:
  [[nodiscard]] Change Update(const UpdateContext& context) override {
    const Change change = PlaceAgain(context);
    if (unplaced_.empty()) {
      wait_ = {};
    } else {
      wait_.Miss("Not shown because a transform is missing: " + ListFirst(unplaced_) + ". " + why_, context.now_s);
    }
    return change;
  }
  [[nodiscard]] Change ApplySettings(const UpdateContext& context) override {
    if (outdated_ || !std::exchange(faded_, false)) return outdated_ ? Update(context) : Change::kNothing;
    for (auto& [shape, mesh] : meshes_) SetColors(mesh);
    PlaceShapes();  // Its links have not moved.
    return Change::kMoving;
  }
  void DrawMoving(const DrawContext& context) override { Draw(context, false); }
  void DrawBlended(const DrawContext& context) override { Draw(context, true); }
  [[nodiscard]] bool blends() const override { return true; }
  void Clear() override { outdated_ = true; }

  [[nodiscard]] std::vector<Setting> Settings() override {
    return {
        {"file", "The robot's description, a URDF.", Setting::Text{&file_}},
        {"packages",
         "A folder of packages with meshes of the description. The folders above the file and those in HGROS_MESH_PATH "
         "and ROS_PACKAGE_PATH are searched, too.",
         Setting::Text{&packages_}},
        {"prefix", "The prefix of each link's name in the frames.", Setting::Text{&prefix_}},
        {"shows", "The visual shapes of the robot, or its collision shapes.",
         Setting::Choice{&side_, {"visual", "collision"}}},
        {"alpha", "Opacity: 0 is invisible, 1 is opaque.", Setting::Number{&alpha_, 0, 1, ""}},
    };
  }
  void OnSetting(const std::string& name) override { (name == "alpha" ? faded_ : outdated_) = true; }

  [[nodiscard]] std::vector<std::string> Status() const override {
    std::vector<std::string> lines;
    if (!fault_.empty()) lines.push_back(fault_);
    if (!wait_.fault().empty()) lines.push_back(wait_.fault());
    if (!missing_.empty())
      lines.push_back("Not shown because a mesh is missing: " + ListFirst(missing_) + ". " + mesh_fault_);
    if (!standing_.at_fixed_frame.empty()) {
      lines.push_back("There are no transforms: " + standing_.at_fixed_frame + " is placed at the fixed frame.");
    }
    if (!standing_.joints_at_zero.empty()) {
      lines.push_back("No transform moves " + ListFirst(standing_.joints_at_zero) +
                      (standing_.joints_at_zero.size() == 1 ? ": it is" : ": they are") +
                      " shown at zero. Publish the joints: docs/tf.md.");
    }
    if (file_.empty()) lines.emplace_back("Set the setting file to a URDF.");
    if (!shapes_.empty()) {
      lines.push_back(Counted(shapes_.size(), "shape", "shapes") + ", " + std::to_string(meshes_.size()) +
                      " of them meshes");
    }
    return lines;
  }
  [[nodiscard]] bool HasFault() const override {
    return !fault_.empty() || !wait_.fault().empty() || !missing_.empty();
  }
  [[nodiscard]] std::string WaitsFor() const override { return wait_.waits_for(); }
  [[nodiscard]] double next_change_s() const override { return wait_.next_change_s(); }
  [[nodiscard]] std::size_t gpu_bytes() const override {
    std::size_t bytes = solids_.gpu_bytes();
    for (const auto& [shape, mesh] : meshes_) bytes += mesh.triangles.gpu_bytes();
    return bytes;
  }
  [[nodiscard]] Eigen::AlignedBox3d Bounds() const override { return bounds_; }

 private:
  struct Mesh {
    std::vector<TriangleCorner> corners;  ///< Without alpha_ applied.
    Triangles triangles;
    Eigen::AlignedBox3d box;
  };

  [[nodiscard]] Rgba Faded(Rgba color) const {
    return (color & 0xFFFFFFU) | static_cast<Rgba>(std::lround(static_cast<float>(AlphaOf(color)) * alpha_)) << 24U;
  }

  void Read() {
    fault_.clear();
    mesh_fault_.clear();
    missing_.clear();
    shapes_.clear();
    meshes_.clear();
    links_.clear();
    described_.clear();
    unplaced_.clear();
    standing_ = {};
    if (file_.empty()) return;
    const auto text = ReadWholeFile(file_);
    if (!text) {
      fault_ = file_ + " is not a file that can be read.";
      return;
    }
    fault_ = ReadRobot(*text, prefix_, static_cast<RobotSide>(side_), shapes_);
    if (fault_.empty()) described_ = ReadRobotLinks(*text, prefix_);
    std::vector<fs::path> folders;
    if (!packages_.empty()) folders.emplace_back(packages_);
    std::error_code ignored;
    for (fs::path above = fs::absolute(file_, ignored).parent_path(); above.has_relative_path();
         above = above.parent_path()) {
      folders.push_back(above);
    }
    folders = MeshFolders(std::move(folders));
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      if (shapes_[i].kind == RobotShape::Kind::kMesh) ReadShapeMesh(i, folders);
    }
  }

  void ReadShapeMesh(std::size_t index, const std::vector<fs::path>& folders) {
    const RobotShape& shape = shapes_[index];
    std::string fault;
    std::vector<TriangleCorner> corners;
    if (const fs::path path = FindMesh(shape.mesh, folders, fault); fault.empty()) fault = ReadMesh(path, corners);
    if (!fault.empty()) {
      if (mesh_fault_.empty()) mesh_fault_ = std::move(fault);
      missing_.push_back(fs::path(shape.mesh).filename());
      return;
    }
    Mesh& mesh = meshes_[index];
    for (TriangleCorner& corner : corners) {
      corner.position = corner.position.cwiseProduct(shape.size);
      if (shape.colored || AlphaOf(corner.color) == 0) corner.color = shape.color;
      mesh.box.extend(corner.position);
    }
    mesh.corners = std::move(corners);
    SetColors(mesh);
  }

  void SetColors(Mesh& mesh) const {
    std::vector<TriangleCorner> corners = mesh.corners;
    for (TriangleCorner& corner : corners) corner.color = Faded(corner.color);
    mesh.triangles.Set(corners);
  }

  [[nodiscard]] Change PlaceAgain(const UpdateContext& context) {
    const bool read = std::exchange(outdated_, false);
    if (read) Read();
    if (std::exchange(faded_, false) && !read) {
      for (auto& [shape, mesh] : meshes_) SetColors(mesh);
      if (!Place(context)) PlaceShapes();
      return Change::kMoving;
    }
    // The first message of any display may choose the fixed frame.
    const bool other_frame = placed_in_ != context.frame.name();
    if (!read && !context.transforms_changed && !context.frame_changed && !other_frame) return Change::kNothing;
    return Place(context) || read ? Change::kMoving : Change::kNothing;
  }

  /// Whether something has moved.
  bool Place(const UpdateContext& context) {
    unplaced_.clear();
    placed_in_ = context.frame.name();
    const auto find = [&](const std::string& link) -> std::optional<Eigen::Isometry3d> {
      RigidTransform T_fixed_link;
      if (context.frame.Find(link, T_fixed_link, why_) != FixedFrame::Answer::kFound) return std::nullopt;
      return T_fixed_link.Isometry();
    };
    standing_ = PlaceLinks(described_, find, context.frame.tree().Edges().empty());
    auto links = std::move(standing_.T_fixed_link);
    for (const RobotShape& shape : shapes_) {
      if (!links.contains(shape.link) && std::ranges::find(unplaced_, shape.link) == unplaced_.end()) {
        unplaced_.push_back(shape.link);
      }
    }
    const bool same = std::ranges::equal(links, links_, [](const auto& a, const auto& b) {
      return a.first == b.first && a.second.matrix() == b.second.matrix();
    });
    if (same && !links_.empty()) return false;
    links_ = std::move(links);
    PlaceShapes();
    return true;
  }

  void PlaceShapes() {
    if (!links_.empty()) origin_ = links_.begin()->second.translation();
    SceneShapes solids;
    bounds_.setEmpty();
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      const RobotShape& shape = shapes_[i];
      const auto link = links_.find(shape.link);
      if (link == links_.end()) continue;
      const Eigen::Isometry3d T_fixed_shape = link->second * shape.T_link_shape;
      if (const auto mesh = meshes_.find(i); mesh != meshes_.end()) {
        bounds_.extend(mesh->second.box.transformed(T_fixed_shape));
      }
      if (shape.kind == RobotShape::Kind::kMesh) continue;
      auto& kind = shape.kind == RobotShape::Kind::kBox      ? solids.cubes
                   : shape.kind == RobotShape::Kind::kSphere ? solids.spheres
                                                             : solids.cylinders;
      SolidShape& solid = kind.emplace_back();
      solid.pose.leftCols<3>() = T_fixed_shape.linear() * shape.size.asDiagonal();
      solid.pose.col(3) = T_fixed_shape.translation() - origin_;
      solid.color = Faded(shape.color);
    }
    if (Eigen::AlignedBox3d box = BoundsOf(solids); !box.isEmpty()) bounds_.extend(box.translate(origin_));
    solids_.Set(solids);
  }

  void Draw(const DrawContext& context, bool blended) {
    solids_.Draw(context, RigidTransform({1, 0, 0, 0}, origin_), blended);
    for (auto& [index, mesh] : meshes_) {
      const auto link = links_.find(shapes_[index].link);
      if (link == links_.end()) continue;
      mesh.triangles.Draw(context, RigidTransform(link->second * shapes_[index].T_link_shape), blended);
    }
  }

  std::vector<RobotShape> shapes_;
  std::vector<RobotLink> described_;
  PlacedLinks standing_;                ///< Without the places of the links.
  std::string placed_in_;               ///< The fixed frame.
  std::map<std::size_t, Mesh> meshes_;  ///< The key is the shape's index.
  std::map<std::string, Eigen::Isometry3d, std::less<>> links_;
  Solids solids_;  ///< Relative to origin_.
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  Eigen::AlignedBox3d bounds_;
  TransformWait wait_;
  std::string fault_, why_, mesh_fault_;
  std::vector<std::string> unplaced_, missing_;
  bool outdated_ = true;
  bool faded_ = false;  ///< alpha_ has changed.

  std::string file_;
  std::string packages_;
  std::string prefix_;
  int side_ = 0;
  float alpha_ = 1;
};

}  // namespace

DisplayType RobotDisplayType() {
  return {"Robot model", {}, [](const DisplayInputs& /*inputs*/) -> std::unique_ptr<Display> {
            return std::make_unique<RobotDisplay>();
          }};
}

}  // namespace hgros::viewer
