#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>

#include "hgros/transport/transport.hpp"

namespace hgros {

/// Threads that take turns at reading input. Two of them wait for it. When one has found a task and runs it, which
/// may take long, the other continues to wait. So no message has to be passed to another thread.
///
/// Thread safety: thread-safe. Start() and Stop() are called once each.
/// Invariants: at most one thread is inside Input::Lead(). While started, at least one thread waits or reads or is
/// about to, even if tasks block. A task runs on the thread that read it; if that was a thread in Receive(), on one of
/// the pool.
class LeaderPool {
 public:
  using Task = std::function<void()>;

  /// The source of input. Implemented by a transport.
  class Input {
   public:
    virtual ~Input() = default;
    /// Waits until there may be something to read, or something is due, or Wake() was called. Several threads wait at
    /// once. Input wakes at least one of them. Input that arrives while no thread waits wakes the next one that
    /// waits.
    virtual void Wait() noexcept = 0;
    /// Reads without waiting, until there is a task to run or nothing is left. If it returns early it makes sure (Wake)
    /// that another thread reads the rest. One call at a time; each sees what the earlier ones did.
    virtual Task Lead() noexcept = 0;
    virtual void Wake() noexcept = 0;
    /// From here on the calling thread polls with MayRead(), and input wakes no other thread. False if another thread
    /// polls already, or the input cannot be polled.
    virtual bool BeginAsking() noexcept { return false; }
    [[nodiscard]] virtual bool MayRead() const noexcept { return false; }
    /// Input wakes a thread again; also input that has arrived since the last MayRead().
    virtual void EndAsking() noexcept {}
    /// Whether WaitFirst() works.
    [[nodiscard]] virtual bool CanWaitFirst() const noexcept { return false; }
    /// As Wait(), for one thread at a time: input wakes this thread and no other. It does not sleep if `ends()`, nor
    /// for longer than `until`. False: a signal's handler has run. EndAsking() is called when the thread reads no more.
    virtual bool WaitFirst(const std::function<bool()>& /*ends*/,
                           std::chrono::steady_clock::time_point /*until*/) noexcept {
      return true;
    }
    /// Lets WaitFirst() look at `ends` once more.
    virtual void WakeFirst() noexcept {}
  };

  /// `input` outlives the pool.
  explicit LeaderPool(Input& input);
  ~LeaderPool();
  LeaderPool(const LeaderPool&) = delete;
  LeaderPool& operator=(const LeaderPool&) = delete;

  void Start();
  /// Lets running tasks end, then joins all threads. If it is called from within a task, that task's thread is
  /// detached: it ends by itself after the task, without touching pool or input.
  void Stop() noexcept;
  /// Reads on the calling thread until the visit ends. Tasks run on the pool's threads, not here. If another thread
  /// does this already, it only calls `first`.
  void Receive(const Visit& visit) noexcept;
  /// Reads on the calling thread until the visit ends, sleeps meanwhile, and runs the tasks that it reads. It may
  /// return earlier. False at once if another thread visits, or the input cannot be waited for in this way.
  [[nodiscard]] bool ReceiveHere(const Visit& visit) noexcept;
  /// Whether Transport::LeaveRest() was called in the calling thread's task, which is therefore run once more.
  [[nodiscard]] static bool LeftRest() noexcept;
  /// Lets ReceiveHere() look at `done` once more.
  void WakeReceiver() noexcept;
  [[nodiscard]] std::size_t thread_count() const;

 private:
  struct State;  // Shared with the threads: a task may destroy the pool.
  static void Run(const std::shared_ptr<State>& state);
  static void Spawn(const std::shared_ptr<State>& state);
  // False if another thread is reading.
  static bool LeadOnce(State& state) noexcept;

  const std::shared_ptr<State> state_;
};

}  // namespace hgros
