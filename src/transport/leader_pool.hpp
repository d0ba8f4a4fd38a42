#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace hgros {

/// Threads that take turns waiting for input. The one whose turn it is, the leader, waits and reads; before it runs
/// something that may take long it passes its turn on, so that waiting never stops.
///
/// Thread safety: all functions. Start() and Stop() once each.
/// Invariants: at most one thread is inside Input::Lead(). While started, a thread is inside it or on its way there,
/// whatever tasks do. A task runs on the thread that got it, right after the turn was passed on.
class LeaderPool {
 public:
  using Task = std::function<void()>;

  /// What a leader does. Implemented by a carrier.
  class Input {
   public:
    virtual ~Input() = default;
    /// Waits and reads until there is a task to run or Wake() was called; then returns the task, or none.
    virtual Task Lead() noexcept = 0;
    /// Makes the Lead() that runs, or else the next one, return soon.
    virtual void Wake() noexcept = 0;
  };

  /// `input` outlives the pool.
  explicit LeaderPool(Input& input);
  ~LeaderPool();
  LeaderPool(const LeaderPool&) = delete;
  LeaderPool& operator=(const LeaderPool&) = delete;

  void Start();
  /// Lets running tasks end, then joins all threads. Called from within a task it leaves that one's thread, which
  /// then ends by itself after the task and touches neither pool nor input any more.
  void Stop() noexcept;
  [[nodiscard]] std::size_t thread_count() const;

 private:
  struct State;  // Shared with the threads: a task may destroy the pool.
  static void Run(const std::shared_ptr<State>& state);
  static void SpawnLocked(const std::shared_ptr<State>& state);

  const std::shared_ptr<State> state_;
};

}  // namespace hgros
