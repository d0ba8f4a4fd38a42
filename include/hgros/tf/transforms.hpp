#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "hgros/base/export.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/session/session.hpp"
#include "hgros/tf/stamped_edge.hpp"
#include "hgros/tf/transform_tree.hpp"

namespace hgros {

/// What a session's transforms travel on: foxglove::FrameTransforms.
inline constexpr std::string_view kTransformsChannel = "tf";
/// Latched: each session's last message here has all its edges that do not move.
inline constexpr std::string_view kStaticTransformsChannel = "tf_static";

struct TransformsOptions {
  TransformTreeOptions tree{};
  /// The first of several transforms goes out at once; those that are set within this time behind it go out together
  /// when it has passed. Zero: every one at once.
  Duration batch = std::chrono::milliseconds(2);
  /// Of the node "tf", which takes in what others set.
  NodeOptions node = {.name = "tf", .queue = Queue::KeepLast(256)};
  /// Called when transforms that others set have been taken into the tree: for who shows what changes. From the first
  /// FromTF or tree() on, by the threads that run the nodes "tf" and "tf_static", so by two at once. May use the tree,
  /// whose Lookup finds them then; one that throws counts as an error of its node. The destructor waits for a call that
  /// runs. What is set in the tree directly, or forgotten when the clock jumps, is not told.
  std::function<void()> on_received = nullptr;
};

struct TransformsStats {
  std::uint64_t sent_messages = 0;
  std::uint64_t sent_transforms = 0;
  std::uint64_t unsent_transforms = 0;  ///< Nobody outside got them: a lossless subscriber had no room.
  std::uint64_t received_transforms = 0;
  std::uint64_t refused_transforms = 0;  ///< Of those received: the tree did not take them; the log says why.
  std::uint64_t shared_edges = 0;        ///< Edges that two sessions set; the log names them.
};

/// The transforms of a session: what it sets goes into a tree and to whoever listens, and what others set comes into
/// the same tree.
///
///     hgros::Transforms transforms(session);
///     transforms.ToStaticTF("base", "laser", T_base_laser);
///     transforms.ToTF(scan.stamp, "map", "base", T_map_base);
///     if (const auto found = transforms.FromTF("map", "laser", scan.stamp)) Use(found->T_target_source);
///
/// Who only sets transforms subscribes to none: other sessions are asked for theirs from the first call of FromTF or
/// tree() on, and it takes a moment until they are here; tree().Wait waits for one.
///
/// When the session's clock jumps back, as for a recording that begins again, the tree begins anew by itself
/// (TransformTree::BeginAnew): what comes from then on replaces what was there, and what waits goes on waiting.
///
/// Thread safety: all of it, but construction and destruction. Lifetime: ends before its session, and not within one
/// of its callbacks. Errors: the constructor throws Error if the session's clock cannot be watched for jumps.
/// Refusals are results that name the edge; of what others send they are counted and said in the session's log, as are
/// edges that two sessions set.
class HGROS_EXPORT Transforms {
 public:
  explicit Transforms(Session& session, const TransformsOptions& options = {});
  Transforms(const Transforms&) = delete;
  Transforms& operator=(const Transforms&) = delete;
  /// Sends what still waits to be sent.
  ~Transforms();

  /// Sets and sends one transform: the pose of `child` in `parent`. What the tree refuses is not sent.
  /// Errors: throws Error if the channel is used with another type; so do the others that set.
  SetResult ToTF(Time stamp, std::string_view parent, std::string_view child, const RigidTransform& T_parent_child);
  SetResult ToTF(Time stamp, std::string_view parent, std::string_view child, const Eigen::Isometry3d& T_parent_child) {
    return ToTF(stamp, parent, child, RigidTransform(T_parent_child));
  }
  /// Several in one message. Of refused ones the first is returned; the others are taken.
  SetResult ToTF(std::span<const StampedEdge> edges);
  /// For edges that do not move; who comes later gets them, too. Of `edges` the stamps count for nothing.
  SetResult ToStaticTF(std::span<const StampedEdge> edges);
  SetResult ToStaticTF(std::string_view parent, std::string_view child, const RigidTransform& T_parent_child);
  SetResult ToStaticTF(std::string_view parent, std::string_view child, const Eigen::Isometry3d& T_parent_child) {
    return ToStaticTF(parent, child, RigidTransform(T_parent_child));
  }

  /// The pose of `child` in `parent`, the latest or at a time: as TransformTree::Lookup.
  [[nodiscard]] TransformResult FromTF(std::string_view parent, std::string_view child) {
    return tree().Lookup(parent, child);
  }
  [[nodiscard]] TransformResult FromTF(std::string_view parent, std::string_view child, Time time) {
    return tree().Lookup(parent, child, time);
  }

  /// For everything else. What is set in it directly stays in this process.
  [[nodiscard]] TransformTree& tree();

  /// Sends now what waits for the end of a batch.
  void Flush();

  [[nodiscard]] TransformsStats stats() const;

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

}  // namespace hgros
