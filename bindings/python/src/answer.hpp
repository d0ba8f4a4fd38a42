#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>

#include "of_process.hpp"

namespace hgros::python {

/// The reply to one request, for which a thread of the library waits. The first of Reply() and Fail() counts.
/// Thread safety: all functions.
class Answer : public OfProcess {
 public:
  void Reply(std::string data);
  void Fail(std::string reason);
  /// Waits. Errors: throws std::runtime_error with the reason of Fail().
  [[nodiscard]] std::string Wait();

 private:
  void Set(std::optional<std::string>& part, std::string text);

  std::mutex mutex_;
  std::condition_variable set_;
  std::optional<std::string> reply_;
  std::optional<std::string> reason_;
};

}  // namespace hgros::python
