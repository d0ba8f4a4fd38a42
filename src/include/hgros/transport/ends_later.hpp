#pragma once

#include <memory>
#include <vector>

#include "hgros/base/export.hpp"

namespace hgros {

/// Declare it before a lock under which a transport is called. What the transport releases meanwhile on this thread
/// ends with this object, after the lock. A message may end there, and its destructor is the user's code, which may
/// publish or wait for another thread that does.
///
///     EndsLater after_the_lock;
///     const std::scoped_lock lock(mutex_);
///     outbound_->Commit(head, data);
///
/// Thread safety: none; it belongs to the thread that made it.
/// Invariants: they nest. What an inner one has kept passes to the outer one, whose lock may be held.
class HGROS_EXPORT EndsLater {
 public:
  EndsLater() noexcept;
  ~EndsLater();
  EndsLater(const EndsLater&) = delete;
  EndsLater& operator=(const EndsLater&) = delete;

  using Owners = std::vector<std::shared_ptr<const void>>;
  /// For transports, while they hold no lock: keeps `owners` for this thread's innermost object, or ends them now.
  static void Keep(Owners&& owners);

 private:
  EndsLater* const outer_;
  Owners kept_;
};

}  // namespace hgros
