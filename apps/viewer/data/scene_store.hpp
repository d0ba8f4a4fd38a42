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
#include "viewer/data/model_meshes.hpp"
#include "viewer/data/scene_shapes.hpp"

namespace hgros::viewer {

/// The entities of one channel, as foxglove.SceneUpdate or hgros.Shapes change them.
///
/// Thread safety: none.
/// Invariants: at most kMaxEntities, with at most kMaxShapes in all; what is more is left out and said.
class SceneStore {
 public:
  static constexpr std::size_t kMaxEntities = 100'000;
  static constexpr std::size_t kMaxShapes = 1'000'000;

  struct Entity {
    std::string frame;
    Time stamp;
    std::optional<Time> ends;  ///< After that it is no longer shown.
    bool frame_locked = false;
    std::shared_ptr<const SceneShapes> shapes;  ///< In `frame`.
    std::string told;                           ///< What there is to say of it: its name, and notes, in lines.
  };

  /// Deletions first, then entities; each replaces the one of its id as a whole. Returns what is wrong with the first
  /// entity that cannot be shown whole, in a sentence. The lifetime of one without a stamp begins `now`.
  [[nodiscard]] std::string Apply(const foxglove::SceneUpdate& update, Time now = {});
  /// The paper's shapes likewise; each is an entity named as it is, and moves with its frame.
  [[nodiscard]] std::string Apply(const hgros::Shapes& update, Time now = {});
  /// Forgets what has ended; true if something has.
  bool Expire(Time now);
  /// When the next one ends.
  [[nodiscard]] std::optional<Time> NextEnd() const;
  void Clear();

  /// By id.
  [[nodiscard]] const std::map<std::string, Entity>& entities() const noexcept { return entities_; }

  /// When `frame` is where the entity's shapes are; none: now.
  [[nodiscard]] static std::optional<Time> PlacedAt(const Entity& entity);
  /// Where a frame is: T_fixed_frame at that time, or now if there is none; nothing if that is unknown.
  using FramePose = std::function<std::optional<Eigen::Isometry3d>(const std::string& frame, std::optional<Time> at)>;
  struct Drawing {
    SceneShapes shapes;
    std::size_t unplaced = 0;    ///< Entities whose frame is unknown.
    std::string unplaced_frame;  ///< One of those frames.
  };
  /// All entities in the fixed frame, relative to `origin`, which is near what is looked at: so that coordinates stay
  /// small enough for floats.
  [[nodiscard]] Drawing Draw(const FramePose& pose_of, const Eigen::Vector3d& origin) const;
  /// The entity whose surface, `models` included, is the nearest to a place of the fixed frame, but not farther than
  /// `radius_m`; null: none.
  [[nodiscard]] const Entity* EntityAt(const FramePose& pose_of, const ModelMeshes& models, const Eigen::Vector3d& at,
                                       double radius_m) const;

 private:
  // False if there are too many.
  [[nodiscard]] bool HasRoom(const std::string& id) const;
  // Without its shapes if there are too many; then what is wrong.
  [[nodiscard]] std::string Put(const std::string& id, Entity entity);
  // Whether there was one.
  bool EraseIf(const std::function<bool(const Entity& entity)>& concerns);
  void Erase(const std::string& id);
  void Delete(const foxglove::SceneEntityDeletion& deletion);

  std::map<std::string, Entity> entities_;
  std::size_t shapes_ = 0;  ///< Of all entities.
};

}  // namespace hgros::viewer
