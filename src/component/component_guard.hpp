#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

namespace hgros {

// Stands around each callback of one component: hears of exceptions before the graph logs and counts them, and of
// callbacks that take too long, and lets no callback begin while the component is saved.
//
// Thread safety: all functions.
class ComponentGuard {
 public:
  using Listener = std::function<void(const std::string& what)>;
  using LateListener = std::function<void(const std::string& sentence)>;
  // `saves`: the component can be saved. `deadline`: of each callback; 0: none. Without both, callbacks pass without a
  // lock.
  ComponentGuard(bool saves, std::chrono::nanoseconds deadline, Listener listener, LateListener late)
      : saves_(saves), deadline_(deadline), listener_(std::move(listener)), late_(std::move(late)) {}
  ComponentGuard(const ComponentGuard&) = delete;
  ComponentGuard& operator=(const ComponentGuard&) = delete;

  // `node`: of the callback; outlives the call.
  template <class Call>
  decltype(auto) Run(std::string_view node, Call&& call) {
    Pass pass(counts() ? this : nullptr, node);
    return Note(call);
  }
  // Whether it counts callbacks. If not, Note() does all that Run() does.
  [[nodiscard]] bool counts() const noexcept { return saves_ || deadline_.count() > 0; }
  // Only hears of exceptions.
  template <class Call>
  decltype(auto) Note(Call&& call) {
    try {
      return call();
    } catch (const std::exception& error) {
      NoteException(error.what());
      throw;
    } catch (...) {
      NoteException("an exception that is no std::exception");
      throw;
    }
  }
  // Waits until no callback runs, and calls `save` while none can begin. False if the deadline came first. In the
  // second half of that time none begins, unless inside another one, or while one runs that did so from the beginning.
  // If `save` does not return for long, a callback that waits for it tells so.
  bool TryAlone(std::chrono::steady_clock::time_point deadline, const std::function<void()>& save);
  // Tells of those that still run after the deadline, each once.
  void NoteHanging();

 private:
  // A callback that runs. One that begins inside another one always may.
  class Pass {
   public:
    Pass(ComponentGuard* guard, std::string_view of) : node(of), guard_(guard) {
      if (guard_ != nullptr) guard_->Enter(*this);
    }
    Pass(const Pass&) = delete;
    Pass& operator=(const Pass&) = delete;
    ~Pass() {
      if (guard_ != nullptr) guard_->Leave(*this);
    }

    const std::string_view node;
    const std::thread::id thread = std::this_thread::get_id();
    std::uint64_t number = 0;  // Of those that have begun.
    std::chrono::steady_clock::time_point began;
    bool told = false;  // That it is late.

   private:
    ComponentGuard* const guard_;
  };
  void Enter(Pass& pass);
  void Leave(const Pass& pass) noexcept;
  void NoteException(const char* what) noexcept;
  void NoteLate(std::string_view node, std::chrono::nanoseconds time, bool returned) noexcept;
  void NoteSaving() noexcept;

  const bool saves_;
  const std::chrono::nanoseconds deadline_;
  const Listener listener_;
  const LateListener late_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Pass*> passes_;  // Guarded by mutex_. Callbacks that run.
  std::uint64_t begun_ = 0;    // Guarded by mutex_. Callbacks.
  int waiting_ = 0;            // Guarded by mutex_. Threads in TryAlone() that wait.
  int closing_ = 0;            // Guarded by mutex_. Those for which none may begin.
  bool given_ = false;         // Guarded by mutex_. alone_ is for one of them.
  bool alone_ = false;         // Guarded by mutex_. It is saved, or is about to be; none runs.
  bool told_saving_ = false;   // Guarded by mutex_. That this takes long.
};

}  // namespace hgros
