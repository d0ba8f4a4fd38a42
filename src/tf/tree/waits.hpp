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
#include "tf/tree/outcome.hpp"

namespace hgros::tf {

class TreeCore;

/// A wait for a transform. Thread safety: all functions.
class Waiter {
 public:
  /// With a callback, or without one for use with Sleep.
  explicit Waiter(const TransformQuery& query, TransformCallback callback = {});

  [[nodiscard]] const TransformQuery& query() const noexcept { return query_; }
  /// Passes on the result, once.
  void Finish(const TransformResult& result);
  /// No callback starts after this returns, and one on another thread has ended.
  void Cancel();
  [[nodiscard]] bool pending() const;
  /// The result, or nothing at `deadline` or when a stop is requested.
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
  Frame* edge_ = nullptr;        ///< Waits for a stamp of this edge ...
  std::int64_t from_stamp_ = 0;  ///< ... from here on; without an edge, for a new edge in the tree.
};

/// All waits of one tree. Each one waits for one thing: a missing stamp of an edge, or a new edge. The thread that sets
/// it checks only the waits for it.
///
/// Thread safety: all functions. Order of locks: this one's, then the tree's topology or an edge's `write`.
class Waits {
 public:
  explicit Waits(TreeCore& tree) : tree_(&tree) {}

  /// Finishes the wait on this thread if possible. Otherwise the thread that sets what it waits for does.
  void Add(const std::shared_ptr<Waiter>& waiter);
  void Remove(const std::shared_ptr<Waiter>& waiter);
  /// Called when the edge has a stamp that a wait needs, without any lock of the tree.
  void EdgeHasGrown(Frame& edge);
  /// A restarted edge has only its newest stamp left.
  void EdgeHasRestarted();
  /// There is a new edge.
  void TreeHasGrown();
  /// The tree is about to be destroyed.
  void Close();

 private:
  [[nodiscard]] bool Settle(Waiter& waiter, std::optional<TransformResult>& result);
  [[nodiscard]] bool Await(Waiter& waiter, const Frame& growing, std::int64_t from_stamp);
  enum class For : std::uint8_t { kTheEdge, kEverybody };
  void LookAgain(Frame* edge, For whom = For::kTheEdge);

  std::mutex mutex_;
  TreeCore* tree_;  ///< Null after the tree was destroyed.
  std::list<std::shared_ptr<Waiter>> pending_;
};

}  // namespace hgros::tf
