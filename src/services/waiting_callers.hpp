#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace hgros {

class ServiceHost;

// Callbacks of one session that wait for a reply, and the services whose requests they may run meanwhile, since they
// occupy the threads that would run them.
//
// Thread safety: all functions.
class WaitingCallers {
 public:
  // A waiting thread. Nudge() is called when there may be something to run, under the line's mutex.
  class Caller {
   public:
    virtual ~Caller() = default;
    virtual void Nudge() noexcept = 0;
  };

  void Add(const std::shared_ptr<ServiceHost>& host);
  void Remove(const ServiceHost& host);

  void Enter(Caller& caller);
  void Leave(Caller& caller);
  // A request has come, or may be run now. Cheap if nobody waits.
  void Nudge() noexcept;
  // Runs one request of some service on this thread; false if there was none.
  bool RunOne();

 private:
  std::atomic<int> waiting_{0};
  std::mutex mutex_;
  std::vector<Caller*> callers_;
  std::vector<std::weak_ptr<ServiceHost>> hosts_;
};

}  // namespace hgros
