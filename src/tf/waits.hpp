#pragma once

#include <condition_variable>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "hgros/tf/pending_transform.hpp"
#include "hgros/tf/transform_query.hpp"
#include "tf/outcome.hpp"

namespace hgros::tf {

class TreeCore;

/// One who waits for a transform. Thread safety: full.
class Waiter {
 public:
  /// With a callback, or without one for those who sleep in Sleep.
  explicit Waiter(const TransformQuery& query, TransformCallback callback = {});

  [[nodiscard]] const TransformQuery& query() const noexcept { return query_; }
  /// Hands it what came out, once.
  void Finish(const TransformResult& result);
  /// No callback begins afterwards, and one on another thread has returned.
  void Cancel();
  [[nodiscard]] bool pending() const;
  /// What came out, or nothing at `deadline` or when a stop is requested.
  [[nodiscard]] std::optional<TransformResult> Sleep(std::chrono::steady_clock::time_point deadline,
                                                     std::stop_token stop);

 private:
  friend class Waits;
  enum class State : std::uint8_t { kPending, kRunning, kDone };

  const TransformQuery query_;
  TransformCallback callback_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  State state_ = State::kPending;
  std::thread::id runs_on_;
  std::optional<TransformResult> result_;
  // Guarded by the mutex of Waits.
  Frame* edge_ = nullptr;        ///< What it waits for: a stamp of this edge ...
  std::int64_t from_stamp_ = 0;  ///< ... from here on; without an edge, for another edge in the tree.
};

/// All who wait for transforms of one tree. Each waits for one thing: the stamp that some edge lacks, or a new edge.
/// Whoever sets that looks again for those who wait for it, and for nobody else.
///
/// Thread safety: full. Order of locks: this one's, then the tree's topology or an edge's `write`.
class Waits {
 public:
  explicit Waits(TreeCore& tree) : tree_(&tree) {}

  /// Finishes the waiter at once if it can be, in this thread; otherwise whoever sets what it waits for does.
  void Add(const std::shared_ptr<Waiter>& waiter);
  void Remove(const std::shared_ptr<Waiter>& waiter);
  /// The edge has a stamp that somebody waits for. Holding none of the tree's locks.
  void EdgeHasGrown(Frame& edge);
  /// An edge has nothing any more but its newest stamp.
  void EdgeHasBegunAnew();
  /// There is a new edge.
  void TreeHasGrown();
  /// The tree is about to end.
  void Close();

 private:
  [[nodiscard]] bool Settle(Waiter& waiter, std::optional<TransformResult>& result);
  [[nodiscard]] bool Await(Waiter& waiter, const Frame& growing, std::int64_t from_stamp);
  enum class For : std::uint8_t { kTheEdge, kEverybody };
  void LookAgain(Frame* edge, For whom = For::kTheEdge);

  std::mutex mutex_;
  TreeCore* tree_;  ///< Null when the tree has ended.
  std::list<std::shared_ptr<Waiter>> pending_;
};

}  // namespace hgros::tf
