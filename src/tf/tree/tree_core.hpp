#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/tf/edge_snapshot.hpp"
#include "hgros/tf/transform_query.hpp"
#include "hgros/tf/transform_result.hpp"
#include "hgros/tf/transform_tree.hpp"
#include "tf/tree/frame_table.hpp"
#include "tf/tree/memo.hpp"
#include "tf/tree/outcome.hpp"
#include "tf/tree/waits.hpp"

namespace hgros::tf {

struct EdgeValue {
  std::int64_t stamp = 0;
  bool is_static = false;
  RigidTransform T_parent_child;
  PublisherId publisher;
};

/// The state of a TransformTree. Thread safety: all functions.
/// Invariants: edges are added under `topology_`, one at a time, and never removed or moved. So a reader that follows
/// parents sees a part of the tree as it is now or will be.
class TreeCore {
 public:
  explicit TreeCore(const TransformTreeOptions& options);
  TreeCore(const TreeCore&) = delete;
  TreeCore& operator=(const TreeCore&) = delete;
  ~TreeCore();

  [[nodiscard]] FrameTable& frames() noexcept { return frames_; }
  [[nodiscard]] const FrameTable& frames() const noexcept { return frames_; }
  [[nodiscard]] PublisherId Publisher(std::string_view name);

  SetResult Set(FrameId parent, FrameId child, const EdgeValue& value);
  SetResult Set(std::string_view parent, std::string_view child, const EdgeValue& value, std::string_view publisher);

  void RestartTime(std::int64_t latest) noexcept {
    restart_limit_.store(latest, std::memory_order_relaxed);
    time_.fetch_add(1, std::memory_order_release);
  }

  bool RestartEdge(std::string_view child, std::int64_t possible) noexcept;

  void LookupLatest(FrameId target, FrameId source, Outcome& outcome) const;
  void LookupAt(FrameId target, FrameId source, std::int64_t stamp, Outcome& outcome) const;
  void Lookup(const TransformQuery& query, Outcome& outcome) const;

  [[nodiscard]] TransformResult Result(const Outcome& outcome) const;
  [[nodiscard]] TransformFailure Describe(const Outcome& outcome) const;
  /// For an unknown name.
  [[nodiscard]] TransformFailure DescribeUnknown(std::string_view name) const;

  [[nodiscard]] std::vector<EdgeSnapshot> Edges() const;
  [[nodiscard]] const std::shared_ptr<Waits>& waits() const noexcept { return waits_; }

 private:
  friend class Waits;

  SetResult SetFrames(Frame& parent, Frame& child, const EdgeValue& value);
  /// Whether the next transform of the edge replaces all others. Called with the edge's `write` held.
  [[nodiscard]] bool IsRestarting(const Frame& edge) const noexcept {
    return !edge.is_static && edge.time != time_.load(std::memory_order_acquire);
  }
  /// JumpWatch. Called with the edge's `write` held.
  [[nodiscard]] static bool HasJumped(Frame& edge, const EdgeValue& value) noexcept;
  [[nodiscard]] SetFault Connect(Frame& parent, Frame& child, const EdgeValue& value, const Pose& pose);
  [[nodiscard]] SetResult Refuse(SetFault fault, const Frame& parent, const Frame& child, const EdgeValue& value) const;
  /// The path between two frames, cached or in `route`; false with the fault in `outcome`.
  [[nodiscard]] bool FindWay(FrameId target, FrameId source, Memo*& memo, Route& route, Outcome& outcome) const;

  const RingLimits limits_;
  const std::uint64_t number_;  ///< Unique among all trees of the process.
  FrameTable frames_;
  std::atomic<std::uint64_t> time_{0};          ///< Incremented when time restarts ...
  std::atomic<std::int64_t> restart_limit_{0};  ///< ... after this was written: a later stamp does not restart an edge.
  std::atomic<std::uint64_t> restarted_edges_{0};  ///< Number of restarted edges; written under their `write`.
  std::mutex topology_;
  std::uint64_t edge_count_ = 0;    ///< Guarded by topology_.
  bool edges_are_awaited_ = false;  ///< Guarded by topology_.
  mutable std::mutex publishers_mutex_;
  std::vector<std::string> publishers_;
  std::shared_ptr<Waits> waits_;
};

}  // namespace hgros::tf
