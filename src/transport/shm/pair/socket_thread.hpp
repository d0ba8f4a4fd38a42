#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "transport/actions.hpp"
#include "transport/shm/memory/memory.hpp"
#include "transport/shm/pair/pair.hpp"
#include "transport/waker.hpp"

namespace hgros::shm {

/// The thread that waits for a transport's sockets. Other threads pass it work that must be done without their locks.
///
/// Thread safety: Post(), PostFor(), Distrust(), FinishPair() and Wake() are thread-safe. Start() and Stop() once each,
/// on one thread. The rest: on the socket thread, or before Start().
/// Invariants: handler and posted actions run one after another on this thread, which then holds no mutex. Nothing runs
/// after Stop().
class SocketThread {
 public:
  enum class Source : std::uint64_t { kListening = 1, kPair = 2, kPairProcess = 3 };

  /// Does the work. Implemented by Connections.
  class Handler {
   public:
    virtual ~Handler() = default;
    /// Once per turn: does what is due, and returns when the next thing is.
    virtual SteadyTime DoWhatIsDue(SteadyTime now) = 0;
    /// A descriptor is ready. `number`: the pair's; it may have ended by now.
    virtual void OnReady(Source source, std::uint32_t number) = 0;
    /// The peer has written something impossible.
    virtual void OnLie(const std::shared_ptr<Pair>& liar, const std::string& what) = 0;
    /// All was read of a pair that has ended.
    virtual void OnAllRead(const std::shared_ptr<Pair>& pair) = 0;
  };

  /// Throws Error if there are no descriptors left.
  SocketThread();

  /// `handler` outlives Stop().
  void Start(Handler& handler);
  void Stop() noexcept;

  /// False, and errno is set, if the descriptor cannot be waited for. `events`: of epoll.
  [[nodiscard]] bool Watch(const Handle& handle, std::uint32_t events, Source source,
                           std::uint32_t number = 0) noexcept;
  /// False if it is still watched.
  bool Unwatch(const Handle& handle) noexcept;

  /// Runs the action in the next turn.
  void Post(std::function<void()> action);
  void Post(Actions&& actions) {
    if (!actions.empty()) PostAll(std::move(actions));
  }
  /// Runs the action unless the pair is forgotten by then. Its number may then belong to another pair.
  void PostFor(Pair& pair, std::function<void(const std::shared_ptr<Pair>&)> action);
  /// Sends what waits for the pair's socket, as far as the socket accepts it.
  void FlushSoon(Pair& pair);
  /// Ends the pair, because its peer has written something impossible.
  void Distrust(Pair& liar, const std::string& what);
  /// All was read of a pair that has ended.
  void FinishPair(const std::shared_ptr<Pair>& pair);
  /// Starts a turn.
  void Wake() noexcept { waker_.Wake(); }

 private:
  void Run(const std::stop_token& stop);
  void PostAll(Actions&& actions);

  Handle epoll_;
  Waker waker_;
  Handler* handler_ = nullptr;
  std::mutex posted_mutex_;
  Actions posted_;
  std::jthread thread_;
};

}  // namespace hgros::shm
