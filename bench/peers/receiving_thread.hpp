#pragma once

#include <atomic>
#include <thread>
#include <utility>

namespace hgros::bench {

/// A thread that receives until it is stopped. The body checks the flag at least every 50 ms.
class ReceivingThread {
 public:
  template <class Body>
  explicit ReceivingThread(Body body) : thread_([this, body = std::move(body)]() mutable { body(stopped_); }) {}
  ReceivingThread(const ReceivingThread&) = delete;
  ReceivingThread& operator=(const ReceivingThread&) = delete;
  ~ReceivingThread() {
    stopped_.store(true);
    thread_.join();
  }

 private:
  std::atomic<bool> stopped_{false};
  std::thread thread_;
};

}  // namespace hgros::bench
