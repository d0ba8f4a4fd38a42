#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "hgros/base/export.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/session/session.hpp"
#include "hgros/tf/stamped_edge.hpp"
#include "hgros/tf/transform_tree.hpp"

namespace hgros {

namespace tf {
struct EdgeSetter;
}

/// The channel on which sessions exchange transforms that move: foxglove::FrameTransforms.
inline constexpr std::string_view kTransformsChannel = "tf";
/// The channel for static transforms. Latched: each session's last message holds all its static edges.
inline constexpr std::string_view kStaticTransformsChannel = "tf_static";

struct TransformsOptions {
  TransformTreeOptions tree{};
  /// The first transform is sent at once; transforms set within this time after it are sent together when it has
  /// passed. Zero: each one is sent at once.
  Duration batch = std::chrono::milliseconds(2);
  /// Transforms with a stamp further ahead of the session's clock are refused: an edge that has one would take the
  /// transforms after it for too old. Empty: 10 s; with `time: simulated` 1 h, because the clock may lag behind a fast
  /// simulation. Not checked until such a clock was heard. Grows by what the clock of the publisher's host is known to
  /// be ahead (Session::OffsetTo).
  std::optional<Duration> max_ahead = {};
  /// Queue of the node "tf", which receives the transforms of other sessions.
  NodeOptions node = {.name = "tf", .queue = Queue::KeepLast(256)};
  /// Called after received transforms were put into the tree, so that a program can draw what changed. Runs on the
  /// threads of the nodes "tf" and "tf_static", so two calls can overlap. Starts with the subscriptions. May
  /// use the tree, which has the new transforms by then. An exception counts as an error of the node. The destructor
  /// waits for a running call. Not called for transforms set directly in the tree or dropped when the clock jumps.
  std::function<void()> on_received = nullptr;
};

struct TransformsStats {
  std::uint64_t sent_messages = 0;
  std::uint64_t sent_transforms = 0;
  std::uint64_t unsent_transforms = 0;  ///< Not sent to other sessions: a lossless subscriber had no room.
  std::uint64_t received_transforms = 0;
  std::uint64_t refused_transforms = 0;  ///< Received transforms that the tree refused; the log says why.
  /// Edges that two sessions set; the log names them. Static ones are counted when that lasts longer than it takes to
  /// know that a session has gone (7 s by default), others when they have come from the two in turns, five times.
  std::uint64_t shared_edges = 0;
};

/// The transforms of a session in one tree: those it sets, which are also sent to other sessions, and those it
/// receives.
///
///     hgros::Transforms transforms(session);
///     transforms.ToStaticTF("base", "laser", T_base_laser);
///     transforms.ToTF(scan.stamp, "map", "base", T_map_base);
///     if (const auto found = transforms.FromTF("map", "laser", scan.stamp)) Use(found->T_target_source);
///
/// A program that only sets transforms subscribes to none. The first call of FromTF or tree() subscribes, and a move
/// of a component; it takes a moment until transforms of other sessions arrive. tree().Wait waits for one.
///
/// When the session's clock jumps back, for example because a recording restarts, the tree restarts by itself
/// (TransformTree::RestartTime): new transforms replace old ones, and pending waits continue.
///
/// Thread safety: all functions except construction and destruction.
/// Lifetime: ends before its session, and not inside one of its callbacks. A session has at most one at a time. The
///           components of a session share one.
/// Errors: the constructor throws Error if the session has a Transforms already, or if its clock cannot be watched for
/// jumps. Setting returns a result that names the refused edge. Refused transforms of other sessions, and edges that
/// two sessions set, are counted and logged.
class HGROS_EXPORT Transforms {
 public:
  explicit Transforms(Session& session, const TransformsOptions& options = {});
  Transforms(const Transforms&) = delete;
  Transforms& operator=(const Transforms&) = delete;
  /// Sends the transforms that still wait.
  ~Transforms();

  /// Sets and sends one transform: the pose of `child` in `parent`. A transform that the tree refuses is not sent.
  /// Errors: throws Error if the channel is used with another type. The same holds for the other functions that set.
  SetResult ToTF(Time stamp, std::string_view parent, std::string_view child, const RigidTransform& T_parent_child);
  SetResult ToTF(Time stamp, std::string_view parent, std::string_view child, const Eigen::Isometry3d& T_parent_child) {
    return ToTF(stamp, parent, child, RigidTransform(T_parent_child));
  }
  /// Sets several transforms and sends them in one message. Returns the first refusal; the other transforms are used.
  SetResult ToTF(std::span<const StampedEdge> edges);
  /// Sets edges that do not move. Sessions that join later receive them, too. Stamps in `edges` are ignored.
  SetResult ToStaticTF(std::span<const StampedEdge> edges);
  SetResult ToStaticTF(std::string_view parent, std::string_view child, const RigidTransform& T_parent_child);
  SetResult ToStaticTF(std::string_view parent, std::string_view child, const Eigen::Isometry3d& T_parent_child) {
    return ToStaticTF(parent, child, RigidTransform(T_parent_child));
  }

  /// The pose of `child` in `parent`, the latest one or at a time, as TransformTree::Lookup returns it.
  [[nodiscard]] TransformResult FromTF(std::string_view parent, std::string_view child) {
    return tree().Lookup(parent, child);
  }
  [[nodiscard]] TransformResult FromTF(std::string_view parent, std::string_view child, Time time) {
    return tree().Lookup(parent, child, time);
  }

  /// The tree, for everything else. A transform set directly in it stays in this process.
  [[nodiscard]] TransformTree& tree();

  /// Sends the transforms that wait for the end of a batch now.
  void Flush();

  [[nodiscard]] TransformsStats stats() const;

 private:
  friend class TransformsParts;
  class Core;
  Transforms(std::shared_ptr<Core> core, std::shared_ptr<tf::EdgeSetter> setter);
  std::shared_ptr<Core> core_;
  std::shared_ptr<tf::EdgeSetter> setter_;  // Of a component.
};

}  // namespace hgros
