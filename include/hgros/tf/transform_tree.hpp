#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string_view>

#include "hgros/base/export.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/tf/edge_snapshot.hpp"
#include "hgros/tf/pending_transform.hpp"
#include "hgros/tf/transform_query.hpp"
#include "hgros/tf/transform_result.hpp"

namespace hgros {

namespace tf {
class TreeCore;
}

struct TransformTreeOptions {
  /// What an edge remembers: as much time before its newest stamp ...
  Duration buffer = std::chrono::seconds(10);
  /// ... and at most so many transforms (64 bytes each), at least 2.
  std::size_t max_transforms_per_edge = 65536;
  /// So many frames at most, with those whose ids were asked for by name: other sessions name frames, too.
  std::size_t max_frames = 65536;
};

/// Where the frames of a robot lie in one another, over time: a tree whose edges are transforms T_parent_child, each
/// with a buffer of stamped ones or with one that always holds. A look-up goes up from both frames to their nearest
/// common ancestor. Between two stamps the position is interpolated linearly and the rotation by slerp; there is no
/// extrapolation.
///
///     hgros::TransformTree tree;
///     tree.SetStatic("base", "laser", T_base_laser);
///     if (const auto set = tree.Set("map", "base", scan.stamp, T_map_base); !set) Complain(set.text());
///     if (const auto found = tree.Lookup("map", "laser", scan.stamp)) Use(found->T_target_source);
///
/// Frames and edges come with the first Set and stay; several trees may stand side by side until an edge joins them.
///
/// Thread safety: everything may be called by any thread. Look-ups take no lock, wait for no writer and write nothing
/// that others read. Writers of one edge wait for each other, writers of two edges do not. Ordering: a look-up that
/// begins after a Set has returned finds what was set. Errors: look-ups and Set give the reason; only Frame and
/// Publisher throw.
class HGROS_EXPORT TransformTree {
 public:
  explicit TransformTree(const TransformTreeOptions& options = {});
  TransformTree(const TransformTree&) = delete;
  TransformTree& operator=(const TransformTree&) = delete;
  /// Waits that are still pending are forgotten.
  ~TransformTree();

  /// The id of a name; the frame itself is known once an edge has it. Names are told apart to the byte: "/map" is not
  /// "map". Errors: throws Error if it cannot be a name (the rules are those of channels, RequireChannelName), or if
  /// there are too many.
  [[nodiscard]] FrameId Frame(std::string_view name);
  /// None if nobody has used the name yet.
  [[nodiscard]] std::optional<FrameId> Find(std::string_view name) const noexcept;
  /// Empty for an id that is not of this tree. Valid as long as the tree.
  [[nodiscard]] std::string_view Name(FrameId frame) const noexcept;
  /// The id of somebody who sets transforms, for drawings.
  [[nodiscard]] PublisherId Publisher(std::string_view name);

  /// Takes one transform: p_parent = T_parent_child * p_child at `stamp`. Stamps may come in any order; one that is
  /// there already is replaced. In order it takes the same short time whatever the buffer holds, otherwise the buffer
  /// is copied.
  SetResult Set(FrameId parent, FrameId child, Time stamp, const RigidTransform& T_parent_child,
                PublisherId publisher = {});
  SetResult Set(std::string_view parent, std::string_view child, Time stamp, const RigidTransform& T_parent_child,
                std::string_view publisher = {});
  /// For edges that do not move. The newest holds for all times.
  SetResult SetStatic(FrameId parent, FrameId child, const RigidTransform& T_parent_child, PublisherId publisher = {});
  SetResult SetStatic(std::string_view parent, std::string_view child, const RigidTransform& T_parent_child,
                      std::string_view publisher = {});

  /// Time has jumped back, as when a recording begins again: of each edge that moves, the next transform replaces all
  /// that it has. Until then it is found as before, and who waits for what is too old waits on. With `latest`, what has
  /// a later stamp was still under way when time jumped, and goes to what was before.
  void BeginAnew(Time latest = Time::Never()) noexcept;

  /// T_target_source, at the latest time that every edge between the two knows of.
  [[nodiscard]] TransformResult Lookup(FrameId target, FrameId source) const;
  [[nodiscard]] TransformResult Lookup(std::string_view target, std::string_view source) const;
  /// At `time`.
  [[nodiscard]] TransformResult Lookup(FrameId target, FrameId source, Time time) const;
  [[nodiscard]] TransformResult Lookup(std::string_view target, std::string_view source, Time time) const;
  /// As the query says.
  [[nodiscard]] TransformResult Lookup(const TransformQuery& query) const;
  /// Time travel; see TransformQuery.
  [[nodiscard]] TransformResult Lookup(std::string_view target, Time target_time, std::string_view source,
                                       Time source_time, std::string_view fixed) const;

  /// Whether Lookup would find it; says not why not, and is cheap when it is not there.
  [[nodiscard]] bool CanTransform(const TransformQuery& query) const;
  [[nodiscard]] bool CanTransform(std::string_view target, std::string_view source) const;
  [[nodiscard]] bool CanTransform(std::string_view target, std::string_view source, Time time) const;

  /// Sleeps until the transform is there, cannot come any more (kTooOld), `timeout` has passed (kTimeout) or `stop` is
  /// requested (kStopped). Sets wake it only when they may decide it.
  [[nodiscard]] TransformResult Wait(const TransformQuery& query, Duration timeout, std::stop_token stop = {}) const;

  /// Calls `callback` once, as soon as the transform is there or cannot come any more: before this returns, or later on
  /// the thread whose Set decides it, after that transform is in place. The callback may use the tree. One that throws
  /// is caught, and that is said on standard error. Lifetime: ends with the handle, whose destructor waits for a
  /// callback in flight on another thread; with the tree, too, which does not call it.
  [[nodiscard]] PendingTransform WhenAvailable(const TransformQuery& query, TransformCallback callback) const;

  /// Every edge as it is now, parents before their children and siblings by name.
  [[nodiscard]] std::vector<EdgeSnapshot> Edges() const;

 private:
  std::shared_ptr<tf::TreeCore> core_;
};

}  // namespace hgros
