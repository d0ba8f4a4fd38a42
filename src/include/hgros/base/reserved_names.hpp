#pragma once

#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "hgros/base/fork_guard.hpp"

namespace hgros {

/// Names that only one owner may have at a time.
///
/// Thread safety: all functions.
class ReservedNames {
 public:
  /// Reserves the name until the result is destroyed, which may be after this object. Null if the name is taken.
  [[nodiscard]] std::shared_ptr<const void> TryReserve(std::string_view name) {
    const std::scoped_lock lock(taken_->mutex);
    const auto [place, fresh] = taken_->names.emplace(name);
    if (!fresh) return nullptr;
    return {static_cast<const void*>(&*place), [taken = taken_, place = place](const void*) {
              if (taken->fork.IsChild()) return;  // Another thread of the parent may have held the mutex.
              const std::scoped_lock lock_at_end(taken->mutex);
              taken->names.erase(place);
            }};
  }

 private:
  struct Taken {
    const ForkGuard fork;
    std::mutex mutex;
    std::set<std::string, std::less<>> names;
  };
  const std::shared_ptr<Taken> taken_ = std::make_shared<Taken>();
};

}  // namespace hgros
