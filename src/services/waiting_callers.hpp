#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace hgros {

class ServiceHost;

// The callbacks of one session that wait for a reply, and the services whose requests they may run meanwhile. They run
// requests because they occupy the threads that would otherwise run them.
//
// Thread safety: all functions.
class WaitingCallers {
 public:
  // A waiting thread. Nudge() is called under mutex_ when there may be a request to run.
  class Caller {
   public:
    virtual ~Caller() = default;
    virtual void Nudge() noexcept = 0;
  };

  void Add(const std::shared_ptr<ServiceHost>& host);
  void Remove(const ServiceHost& host);

  void Enter(Caller& caller);
  void Leave(Caller& caller);
  // Wakes all waiting threads: a request came, or can run now. Cheap if no thread waits.
  void Nudge() noexcept;
  // Runs one request of any service on this thread. False if there was none.
  bool RunOne();

 private:
  std::atomic<int> waiting_{0};
  std::mutex mutex_;
  std::vector<Caller*> callers_;
  std::vector<std::weak_ptr<ServiceHost>> hosts_;
};

}  // namespace hgros
