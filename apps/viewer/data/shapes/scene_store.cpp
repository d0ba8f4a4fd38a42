#include "viewer/data/shapes/scene_store.hpp"

#include <algorithm>

#include "viewer/data/cut_text.hpp"
#include "viewer/data/shapes/far_shapes.hpp"
#include "viewer/data/shapes/scene_reader.hpp"
#include "viewer/data/shapes/shape_distance.hpp"
#include "viewer/data/shapes/shape_reader.hpp"
#include "viewer/data/stamp.hpp"

namespace hgros::viewer {
namespace {

using Pose = Eigen::Matrix<double, 3, 4>;

constexpr std::int64_t kForEverS = 1'000'000'000;
constexpr int kMostNotes = 12;              ///< Metadata entries that are shown for an entity, ...
constexpr std::size_t kMostNoteBytes = 80;  ///< ... and bytes of each name or value.

std::string Short(const std::string& text) {
  const std::string_view shown = CutText(text, kMostNoteBytes);
  return std::string(shown) + (shown.size() < text.size() ? "..." : "");
}

std::string ToldOf(const foxglove::SceneEntity& entity) {
  std::string told = "entity \"" + Short(entity.id()) + "\"";
  const int notes = entity.metadata_size();
  for (int i = 0; i < std::min(notes, kMostNotes); ++i) {
    told += "\n" + Short(entity.metadata(i).key()) + " = " + Short(entity.metadata(i).value());
  }
  if (notes > kMostNotes) told += "\nand " + std::to_string(notes - kMostNotes) + " more";
  return told;
}

Pose Moved(const Eigen::Isometry3d& T, const Pose& pose) {
  Pose moved = T.linear() * pose;
  moved.col(3) += T.translation();
  return moved;
}

template <class Shape>
void AddMoved(const Eigen::Isometry3d& T, const std::vector<Shape>& from, std::vector<Shape>& to) {
  for (const Shape& shape : from) to.emplace_back(shape).pose = Moved(T, shape.pose);
}

void AddMoved(const Eigen::Isometry3d& T, const SceneShapes& from, SceneShapes& to) {
  AddMoved(T, from.cubes, to.cubes);
  AddMoved(T, from.spheres, to.spheres);
  AddMoved(T, from.cylinders, to.cylinders);
  AddMoved(T, from.texts, to.texts);
  AddMoved(T, from.models, to.models);
  for (const LinePiece& line : from.lines) {
    LinePiece& moved = to.lines.emplace_back(line);
    moved.from = T * line.from;
    moved.to = T * line.to;
  }
  for (const TriangleCorner& corner : from.triangles) to.triangles.push_back({T * corner.position, corner.color});
}

/// A sentence about left-out entities; empty: there are none.
std::string FarOnes(SceneShapes& shapes) {
  const std::size_t far = LeaveOutFar(shapes);
  if (far == 0) return {};
  return std::to_string(far) + " of its shapes are farther away or larger than 1,000,000 km, and are left out.";
}

std::string TooMany() {
  return "More than " + std::to_string(SceneStore::kMaxEntities) + " entities: the rest is left out.";
}

}  // namespace

void SceneStore::Clear() {
  entities_.clear();
  shapes_ = 0;
}

bool SceneStore::EraseIf(const std::function<bool(const Entity& entity)>& concerns) {
  return std::erase_if(entities_, [&](const auto& entry) {
           const bool erased = concerns(entry.second);
           if (erased) shapes_ -= entry.second.shapes->size();
           return erased;
         }) > 0;
}

void SceneStore::Erase(const std::string& id) {
  const auto found = entities_.find(id);
  if (found == entities_.end()) return;
  shapes_ -= found->second.shapes->size();
  entities_.erase(found);
}

std::string SceneStore::Put(const std::string& id, Entity entity) {
  Erase(id);
  std::string fault;
  if (entity.shapes->size() > most_shapes_ - shapes_) {
    fault = "With it there are more than " + std::to_string(most_shapes_) + " shapes, and it is left out.";
    entity.shapes = std::make_shared<SceneShapes>();
  }
  shapes_ += entity.shapes->size();
  entities_.emplace(id, std::move(entity));
  return fault;
}

void SceneStore::Delete(const foxglove::SceneEntityDeletion& deletion) {
  const Time before = StampOf(deletion.timestamp());
  const auto concerns = [&](const Entity& entity) {
    return before.nanoseconds == 0 || entity.stamp.nanoseconds < before.nanoseconds;
  };
  if (deletion.type() == foxglove::SceneEntityDeletion::ALL) {
    EraseIf(concerns);
  } else if (const auto found = entities_.find(deletion.id()); found != entities_.end() && concerns(found->second)) {
    Erase(deletion.id());
  }
}

std::string SceneStore::Apply(const foxglove::SceneUpdate& update, Time now) {
  for (const auto& deletion : update.deletions()) Delete(deletion);
  std::string first_fault;
  for (const auto& said : update.entities()) {
    if (!HasRoom(said.id())) return TooMany();
    auto shapes = std::make_shared<SceneShapes>();
    std::string fault = ReadScene(said, *shapes);
    if (std::string far = FarOnes(*shapes); fault.empty()) fault = std::move(far);
    Entity entity;
    entity.frame = said.frame_id();
    entity.stamp = StampOf(said.timestamp());
    if (const auto& lifetime = said.lifetime(); lifetime.seconds() >= 0 && lifetime.seconds() < kForEverS) {
      const Duration lasts(lifetime.seconds() * 1'000'000'000 + lifetime.nanos());
      const Time begin = entity.stamp.nanoseconds == 0 ? now : entity.stamp;
      if (lasts > Duration::zero()) entity.ends = Later(begin, lasts);
    }
    entity.frame_locked = said.frame_locked();
    entity.told = ToldOf(said);
    entity.shapes = std::move(shapes);
    if (std::string left_out = Put(said.id(), std::move(entity)); !left_out.empty()) fault = std::move(left_out);
    if (!fault.empty() && first_fault.empty()) first_fault = "Entity \"" + said.id() + "\": " + fault;
  }
  return first_fault;
}

bool SceneStore::HasRoom(const std::string& id) const {
  return entities_.size() < kMaxEntities || entities_.contains(id);
}

std::string SceneStore::Apply(const hgros::Shapes& update, Time /*now*/) {
  if (update.remove_all()) Clear();
  for (const std::string& name : update.removed()) Erase(name);
  std::string first_fault;
  for (const auto& shape : update.shapes()) {
    if (!HasRoom(shape.name())) return TooMany();
    auto shapes = std::make_shared<SceneShapes>();
    std::string fault = ReadShape(shape, *shapes);
    if (std::string far = FarOnes(*shapes); fault.empty()) fault = std::move(far);
    Entity entity;
    entity.frame = update.frame_id();
    entity.stamp = StampOf(update.timestamp());
    entity.frame_locked = true;
    entity.told = "shape \"" + Short(shape.name()) + "\"";
    entity.shapes = std::move(shapes);
    if (std::string left_out = Put(shape.name(), std::move(entity)); !left_out.empty()) fault = std::move(left_out);
    if (!fault.empty() && first_fault.empty()) first_fault = "Shape \"" + shape.name() + "\": " + fault;
  }
  return first_fault;
}

bool SceneStore::Expire(Time now) {
  return EraseIf([&](const Entity& entity) { return entity.ends && entity.ends->nanoseconds <= now.nanoseconds; });
}

std::optional<Time> SceneStore::NextEnd() const {
  std::optional<Time> next;
  for (const auto& [id, entity] : entities_) {
    if (entity.ends && (!next || entity.ends->nanoseconds < next->nanoseconds)) next = entity.ends;
  }
  return next;
}

std::optional<Time> SceneStore::PlacedAt(const Entity& entity) {
  if (entity.frame_locked || entity.stamp.nanoseconds == 0) return std::nullopt;
  return entity.stamp;
}

const SceneStore::Entity* SceneStore::EntityAt(const FramePose& pose_of, const ModelMeshes& models,
                                               const Eigen::Vector3d& at, double radius_m) const {
  const Entity* nearest = nullptr;
  for (const auto& [id, entity] : entities_) {
    const auto T_fixed_frame = pose_of(entity.frame, PlacedAt(entity));
    if (!T_fixed_frame) continue;
    const Eigen::Vector3d in_frame = T_fixed_frame->inverse() * at;
    const double distance =
        std::min(DistanceTo(*entity.shapes, in_frame), models.DistanceTo(entity.shapes->models, in_frame, radius_m));
    if (distance > radius_m) continue;
    radius_m = distance;
    nearest = &entity;
  }
  return nearest;
}

SceneStore::Drawing SceneStore::Draw(const FramePose& pose_of, const Eigen::Vector3d& origin) const {
  Drawing drawing;
  for (const auto& [id, entity] : entities_) {
    const auto T_fixed_frame = pose_of(entity.frame, PlacedAt(entity));
    if (!T_fixed_frame) {
      ++drawing.unplaced;
      drawing.unplaced_frame = entity.frame;
      continue;
    }
    AddMoved(Eigen::Translation3d(-origin) * *T_fixed_frame, *entity.shapes, drawing.shapes);
  }
  return drawing;
}

}  // namespace hgros::viewer
