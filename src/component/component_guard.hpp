#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <utility>

namespace hgros {

// Stands around each callback of one component: hears of exceptions before the graph logs and counts them, and lets no
// callback begin while the component is saved.
//
// Thread safety: all functions.
class ComponentGuard {
 public:
  using Listener = std::function<void(const std::string& what)>;
  // `saves`: the component can be saved. Otherwise callbacks pass without a lock.
  ComponentGuard(bool saves, Listener listener) : saves_(saves), listener_(std::move(listener)) {}
  ComponentGuard(const ComponentGuard&) = delete;
  ComponentGuard& operator=(const ComponentGuard&) = delete;

  template <class Call>
  decltype(auto) Run(Call&& call) {
    const Pass pass(saves_ ? this : nullptr);
    try {
      return call();
    } catch (const std::exception& error) {
      Note(error.what());
      throw;
    } catch (...) {
      Note("an exception that is no std::exception");
      throw;
    }
  }
  // Waits until no callback runs, and calls `save` while none can begin. False if the deadline came first.
  bool TryAlone(std::chrono::steady_clock::time_point deadline, const std::function<void()>& save);

 private:
  // A callback that runs. One that begins inside another one always may.
  class Pass {
   public:
    explicit Pass(ComponentGuard* guard) : guard_(guard) {
      if (guard_ != nullptr) guard_->Enter();
    }
    Pass(const Pass&) = delete;
    Pass& operator=(const Pass&) = delete;
    ~Pass() {
      if (guard_ != nullptr) guard_->Leave();
    }

   private:
    ComponentGuard* const guard_;
  };
  void Enter();
  void Leave();
  void Note(const char* what) noexcept;

  const bool saves_;
  const Listener listener_;
  std::mutex mutex_;
  std::condition_variable changed_;
  int running_ = 0;     // Guarded by mutex_. Callbacks.
  bool alone_ = false;  // Guarded by mutex_. It is saved; running_ is 0.
};

}  // namespace hgros
