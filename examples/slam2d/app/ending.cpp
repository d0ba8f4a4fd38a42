#include "ending.hpp"

#include <algorithm>

namespace slam2d {

void Ending::Decide(int exit_code, std::string sentence) {
  {
    const std::scoped_lock lock(mutex_);
    if (exit_code_) return;
    exit_code_ = exit_code;
    sentence_ = std::move(sentence);
  }
  changed_.notify_all();
  stop_.request_stop();
}

void Ending::FailAt(std::chrono::steady_clock::time_point when, std::string sentence) {
  {
    const std::scoped_lock lock(mutex_);
    if (fail_at_ && *fail_at_ <= when) return;
    fail_at_ = when;
    fail_sentence_ = std::move(sentence);
  }
  changed_.notify_all();
}

bool Ending::WaitUntil(std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  while (!exit_code_) {
    const auto now = std::chrono::steady_clock::now();
    if (fail_at_ && *fail_at_ <= now) {
      const std::string sentence = fail_sentence_;
      lock.unlock();
      Fail(sentence);
      return true;
    }
    if (deadline <= now) return false;
    changed_.wait_until(lock, fail_at_ ? std::min(*fail_at_, deadline) : deadline);
  }
  return true;
}

int Ending::exit_code() const {
  const std::scoped_lock lock(mutex_);
  return exit_code_.value_or(kFailure);
}

std::string Ending::sentence() const {
  const std::scoped_lock lock(mutex_);
  return sentence_;
}

}  // namespace slam2d
