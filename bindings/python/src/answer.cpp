#include "answer.hpp"

#include <stdexcept>
#include <utility>

namespace hgros::python {

void Answer::Reply(std::string data) { Set(reply_, std::move(data)); }

void Answer::Fail(std::string reason) { Set(reason_, std::move(reason)); }

void Answer::Set(std::optional<std::string>& part, std::string text) {
  RefuseInChild();
  {
    const std::scoped_lock lock(mutex_);
    if (reply_ || reason_) return;
    part = std::move(text);
  }
  set_.notify_all();
}

std::string Answer::Wait() {
  std::unique_lock lock(mutex_);
  set_.wait(lock, [this] { return reply_ || reason_; });
  if (reason_) throw std::runtime_error(*reason_);
  return std::move(*reply_);
}

}  // namespace hgros::python
