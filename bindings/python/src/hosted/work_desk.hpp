#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "inbox.hpp"
#include "ready_list.hpp"

namespace hgros::python {

/// Where threads of the library leave work for one thread of Python, and wait for the result without the GIL.
///
/// Thread safety: all functions.
class WorkDesk {
 public:
  WorkDesk() : ready_(MakeShared<ReadyList>()), inbox_(MakeShared<Inbox>(ready_, 0)) {}

  /// Calls `work` with the GIL on the thread of Python, and returns what that returns. The thread that waits must not
  /// have the GIL; on the thread of Python itself, `work` runs at once.
  /// Errors: throws std::runtime_error with the text and the traceback of what `work` raised.
  [[nodiscard]] std::string Run(const std::function<std::string()>& work);
  /// Called once on the thread of Python, which from then on takes the work out of the inbox.
  void Settle() noexcept { thread_ = std::this_thread::get_id(); }

  [[nodiscard]] const std::shared_ptr<ReadyList>& ready() const noexcept { return ready_; }
  [[nodiscard]] const std::shared_ptr<Inbox>& inbox() const noexcept { return inbox_; }

 private:
  std::atomic<std::thread::id> thread_{};
  std::shared_ptr<ReadyList> ready_;
  std::shared_ptr<Inbox> inbox_;
};

}  // namespace hgros::python
