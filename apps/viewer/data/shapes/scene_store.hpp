#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "foxglove/SceneUpdate.pb.h"
#include "hgros/Shapes.pb.h"
#include "hgros/clock/time.hpp"
#include "viewer/data/mesh/model_meshes.hpp"
#include "viewer/data/shapes/scene_shapes.hpp"

namespace hgros::viewer {

/// The entities of one channel, as foxglove.SceneUpdate or hgros.Shapes change them.
///
/// Thread safety: none. Invariants: at most kMaxEntities with at most `most_shapes` in total. The rest is left out
/// and reported.
class SceneStore {
 public:
  static constexpr std::size_t kMaxEntities = 100'000;
  static constexpr std::size_t kMaxShapes = 1'000'000;

  struct Entity {
    std::string frame;
    Time stamp;
    std::optional<Time> ends;  ///< When it stops being shown.
    bool frame_locked = false;
    std::shared_ptr<const SceneShapes> shapes;  ///< In `frame`.
    std::string told;                           ///< Its name and metadata, as lines.
  };

  explicit SceneStore(std::size_t most_shapes = kMaxShapes) noexcept : most_shapes_(most_shapes) {}

  /// Applies deletions first, then entities. Each entity replaces the one with its id. The lifetime of an entity
  /// without a stamp begins `now`. Returns what is wrong with the first entity that cannot be shown completely, as a
  /// sentence.
  [[nodiscard]] std::string Apply(const foxglove::SceneUpdate& update, Time now = {});
  /// The same for the paper's shapes. Each shape is an entity with the shape's name and moves with its frame.
  [[nodiscard]] std::string Apply(const hgros::Shapes& update, Time now = {});
  /// Removes entities whose lifetime is over. Returns whether there were any.
  bool Expire(Time now);
  /// When the next lifetime ends.
  [[nodiscard]] std::optional<Time> NextEnd() const;
  void Clear();

  /// By id.
  [[nodiscard]] const std::map<std::string, Entity>& entities() const noexcept { return entities_; }

  /// The time at which `frame` places the entity; none: now.
  [[nodiscard]] static std::optional<Time> PlacedAt(const Entity& entity);
  /// Finds T_fixed_frame at that time, or now if no time is given. None if it is unknown.
  using FramePose = std::function<std::optional<Eigen::Isometry3d>(const std::string& frame, std::optional<Time> at)>;
  struct Drawing {
    SceneShapes shapes;
    std::size_t unplaced = 0;    ///< Entities whose frame is unknown.
    std::string unplaced_frame;  ///< One of those frames.
  };
  /// All entities in the fixed frame, relative to `origin`. The origin should be close to the view, so that coordinates
  /// fit into floats.
  [[nodiscard]] Drawing Draw(const FramePose& pose_of, const Eigen::Vector3d& origin) const;
  /// The entity whose surface, including `models`, is nearest to a point of the fixed frame and not farther away than
  /// `radius_m`. Null if there is none.
  [[nodiscard]] const Entity* EntityAt(const FramePose& pose_of, const ModelMeshes& models, const Eigen::Vector3d& at,
                                       double radius_m) const;

 private:
  // False if there are too many.
  [[nodiscard]] bool HasRoom(const std::string& id) const;
  // Adds it without its shapes if there are too many. Then it returns what is wrong.
  [[nodiscard]] std::string Put(const std::string& id, Entity entity);
  // Whether there was one.
  bool EraseIf(const std::function<bool(const Entity& entity)>& concerns);
  void Erase(const std::string& id);
  void Delete(const foxglove::SceneEntityDeletion& deletion);

  std::map<std::string, Entity> entities_;
  std::size_t most_shapes_;
  std::size_t shapes_ = 0;  ///< Total of all entities.
};

}  // namespace hgros::viewer
