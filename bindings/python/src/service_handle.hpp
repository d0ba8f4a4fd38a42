#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "answer.hpp"
#include "hgros/services/service.hpp"
#include "inbox.hpp"

namespace hgros::python {

/// Passes requests on to Python, one at a time, and waits for each answer on a dedicated thread of the service.
/// Thread safety: all functions.
class RequestDesk {
 public:
  explicit RequestDesk(std::shared_ptr<Inbox> inbox) : inbox_(std::move(inbox)) {}

  [[nodiscard]] Payload Handle(const RawMessage& request) {
    auto answer = std::make_shared<Answer>();
    {
      const std::scoped_lock lock(mutex_);
      current_ = answer;
      if (ended_) answer->Fail(kEnded);
    }
    inbox_->Push(Request{request, answer});
    const auto data = std::make_shared<const std::string>(answer->Wait());
    return {AsBytes(*data), data};
  }
  /// The request that waits fails, and each one that comes.
  void End() {
    inbox_->Close();
    const std::scoped_lock lock(mutex_);
    ended_ = true;
    if (current_) current_->Fail(kEnded);
  }

 private:
  static constexpr const char* kEnded = "The service has ended.";

  const std::shared_ptr<Inbox> inbox_;
  std::mutex mutex_;
  std::shared_ptr<Answer> current_;
  bool ended_ = false;
};

/// Keeps a service of Python.
class ServiceHandle : public OfProcess {
 public:
  ServiceHandle(Service service, std::shared_ptr<RequestDesk> desk)
      : desk_(std::move(desk)), service_(std::move(service)) {}
  ServiceHandle(const ServiceHandle&) = delete;
  ServiceHandle& operator=(const ServiceHandle&) = delete;
  ~ServiceHandle() { End(); }

  /// Call it without the GIL. Does nothing in a forked child.
  void End() {
    if (of_parent()) return;
    desk_->End();  // First: its thread may wait for an answer.
    service_.Reset();
  }

 private:
  const std::shared_ptr<RequestDesk> desk_;
  Service service_;
};

}  // namespace hgros::python
