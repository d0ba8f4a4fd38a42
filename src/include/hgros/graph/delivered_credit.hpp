#pragma once

#include <memory>
#include <utility>

#include "hgros/base/thread_local.hpp"

namespace hgros {

/// The credit of the remote message that this thread delivers, for callbacks of inline nodes that queue the message
/// themselves: while they keep it, the message counts as not consumed in its sender's window.
class DeliveredCredit {
 public:
  /// `credit` must outlive it.
  explicit DeliveredCredit(const std::shared_ptr<const void>& credit) noexcept
      : outer_(std::exchange(innermost, &credit)) {}
  DeliveredCredit(const DeliveredCredit&) = delete;
  DeliveredCredit& operator=(const DeliveredCredit&) = delete;
  ~DeliveredCredit() { innermost = outer_; }

  /// Null if the message has none.
  [[nodiscard]] static std::shared_ptr<const void> Here() noexcept {
    return innermost == nullptr ? nullptr : *innermost;
  }

 private:
  static inline HGROS_THREAD_LOCAL const std::shared_ptr<const void>* innermost = nullptr;
  const std::shared_ptr<const void>* const outer_;
};

}  // namespace hgros
