#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "hgros/transport/transport.hpp"

namespace hgros {

/// Threads that take turns reading input. Two of them wait for it, so that one is left when the other has found
/// something that may take long and runs it: nothing has to be passed on, and waiting never stops.
///
/// Thread safety: all functions. Start() and Stop() once each.
/// Invariants: at most one thread is inside Input::Lead(). While started, at least one thread waits or reads or is on
/// its way there, whatever tasks do. A task runs on the thread that read it, or, if that was a visitor,
/// on one of the pool.
class LeaderPool {
 public:
  using Task = std::function<void()>;

  /// Where input comes from. Implemented by a carrier.
  class Input {
   public:
    virtual ~Input() = default;
    /// Waits until there may be something to read, or something is due, or Wake() was called. Several threads wait at
    /// once; what comes wakes at least one of them, and what comes while none waits is kept for the next.
    virtual void Wait() noexcept = 0;
    /// Reads without waiting, until there is a task to run or nothing left. Who returns early makes sure (Wake) that
    /// another thread reads the rest. One call at a time; each sees what the ones before did.
    virtual Task Lead() noexcept = 0;
    virtual void Wake() noexcept = 0;
    /// From here on the calling thread asks again and again whether there is something to read, and what comes wakes no
    /// other. False if another thread does so already, or the input cannot be asked.
    virtual bool BeginAsking() noexcept { return false; }
    [[nodiscard]] virtual bool MayRead() const noexcept { return false; }
    /// What comes, or came after the last question, wakes a thread again.
    virtual void EndAsking() noexcept {}
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
  /// Reads on the calling thread, in rounds that end. Tasks do not run here, but on the pool's threads. Returns after
  /// `first` if another thread does so.
  void Receive(const Visit& visit) noexcept;
  /// Whether the calling thread is in Receive().
  [[nodiscard]] static bool IsVisitor() noexcept;
  [[nodiscard]] std::size_t thread_count() const;

 private:
  struct State;  // Shared with the threads: a task may destroy the pool.
  static void Run(const std::shared_ptr<State>& state);
  static void Spawn(const std::shared_ptr<State>& state);
  // False if another thread reads just now.
  static bool LeadOnce(State& state) noexcept;

  const std::shared_ptr<State> state_;
};

}  // namespace hgros
