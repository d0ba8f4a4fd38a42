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
  /// An edge remembers transforms this long before its newest stamp ...
  Duration buffer = std::chrono::seconds(10);
  /// ... but at most this number of transforms (64 bytes each); at least 2.
  std::size_t max_transforms_per_edge = 65536;
  /// Maximum number of frames. Names that were only asked for count, too: other sessions also name frames.
  std::size_t max_frames = 65536;
};

/// The frames of a robot over time: a tree whose edges are transforms T_parent_child. A moving edge has a buffer of
/// stamped transforms, a static edge has one that always holds. A lookup follows both frames up to their nearest
/// common ancestor. Between two stamps the position is interpolated linearly and the rotation by slerp. There is no
/// extrapolation.
///
///     hgros::TransformTree tree;
///     tree.SetStatic("base", "laser", T_base_laser);
///     if (const auto set = tree.Set("map", "base", scan.stamp, T_map_base); !set) Complain(set.text());
///     if (const auto found = tree.Lookup("map", "laser", scan.stamp)) Use(found->T_target_source);
///
/// The first Set adds frames and edges, and they stay. Separate trees can exist until an edge joins them.
///
/// Thread safety: every function may be called by any thread. Lookups take no lock, do not wait for writers and write
/// nothing that other threads read. Writers of the same edge wait for each other; writers of different edges do not.
/// Ordering:  a lookup that begins after Set returned finds what was set.
/// Errors:    lookups and Set return the reason. Only Frame and Publisher throw.
class HGROS_EXPORT TransformTree {
 public:
  explicit TransformTree(const TransformTreeOptions& options = {});
  TransformTree(const TransformTree&) = delete;
  TransformTree& operator=(const TransformTree&) = delete;
  /// Drops waits that are still pending.
  ~TransformTree();

  /// The id of a name. The frame is known once an edge has it. Names are compared byte by byte: "/map" is not "map".
  /// Errors: throws Error if the text cannot be a name (RequireChannelName has the rules) or there are too many frames.
  [[nodiscard]] FrameId Frame(std::string_view name);
  /// Empty if the name was never used.
  [[nodiscard]] std::optional<FrameId> Find(std::string_view name) const noexcept;
  /// Empty for an id of another tree. Valid as long as the tree.
  [[nodiscard]] std::string_view Name(FrameId frame) const noexcept;
  /// The id of a publisher of transforms, for drawings and for Set.
  [[nodiscard]] PublisherId Publisher(std::string_view name);

  /// Sets one transform: p_parent = T_parent_child * p_child at `stamp`. Stamps may come in any order; an equal stamp
  /// replaces the old transform. In order it takes constant time, out of order the edge's buffer is copied. If all
  /// stamps of 2 s, at least one each second, are more than 1 s before the newest one, are of its publisher and do not
  /// descend, time has jumped back for this edge, as when a recording starts again: the transform replaces all others
  /// (SetResult::jumped_back).
  SetResult Set(FrameId parent, FrameId child, Time stamp, const RigidTransform& T_parent_child,
                PublisherId publisher = {});
  SetResult Set(std::string_view parent, std::string_view child, Time stamp, const RigidTransform& T_parent_child,
                std::string_view publisher = {});
  /// Sets an edge that does not move. The newest transform holds for all times.
  SetResult SetStatic(FrameId parent, FrameId child, const RigidTransform& T_parent_child, PublisherId publisher = {});
  SetResult SetStatic(std::string_view parent, std::string_view child, const RigidTransform& T_parent_child,
                      std::string_view publisher = {});

  /// Time has jumped back, for example because a recording restarts. The next transform of each moving edge replaces
  /// all transforms of that edge. Until then the old ones are found, and waits for a stamp that is too old continue. A
  /// transform with a stamp after `latest` was still on its way when time jumped; it is added to the old ones.
  void RestartTime(Time latest = Time::Never()) noexcept;
  /// The clock that gave the stamps of the edge above `child` was set back, and gives none after `possible` now. If the
  /// edge has such stamps, its next transform that is too old for it replaces all of them. Returns whether it has.
  bool RestartEdge(std::string_view child, Time possible) noexcept;

  /// T_target_source at the latest time that all edges between the two frames have.
  [[nodiscard]] TransformResult Lookup(FrameId target, FrameId source) const;
  [[nodiscard]] TransformResult Lookup(std::string_view target, std::string_view source) const;
  /// T_target_source at `time`.
  [[nodiscard]] TransformResult Lookup(FrameId target, FrameId source, Time time) const;
  [[nodiscard]] TransformResult Lookup(std::string_view target, std::string_view source, Time time) const;
  /// T_target_source as the query asks.
  [[nodiscard]] TransformResult Lookup(const TransformQuery& query) const;
  /// Time travel; see TransformQuery.
  [[nodiscard]] TransformResult Lookup(std::string_view target, Time target_time, std::string_view source,
                                       Time source_time, std::string_view fixed) const;

  /// Whether Lookup would find a transform. Cheaper than a failing Lookup, because it does not describe the reason.
  [[nodiscard]] bool CanTransform(const TransformQuery& query) const;
  [[nodiscard]] bool CanTransform(std::string_view target, std::string_view source) const;
  [[nodiscard]] bool CanTransform(std::string_view target, std::string_view source, Time time) const;

  /// Sleeps until the transform is there, can no longer come (kTooOld), `timeout` has passed (kTimeout) or `stop` is
  /// requested (kStopped). It wakes up only for transforms that can decide it.
  [[nodiscard]] TransformResult Wait(const TransformQuery& query, Duration timeout, std::stop_token stop = {}) const;

  /// Calls `callback` once, when the transform is there or can no longer come: before this function returns, or later
  /// on the thread whose Set decides it, after that transform was stored. The callback may use the tree. If it throws,
  /// the exception is caught and printed to standard error.
  /// Lifetime: ends with the handle, whose destructor waits for a callback that runs on another thread, or with the
  /// tree, which then does not call it.
  [[nodiscard]] PendingTransform WhenAvailable(const TransformQuery& query, TransformCallback callback) const;

  /// All edges at this moment, parents before their children and siblings by name.
  [[nodiscard]] std::vector<EdgeSnapshot> Edges() const;

 private:
  std::shared_ptr<tf::TreeCore> core_;
};

}  // namespace hgros
