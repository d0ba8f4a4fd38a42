#pragma once

#include <memory>
#include <vector>

#include "hgros/base/export.hpp"

namespace hgros {

/// Declare it before a lock under which a transport is called. Objects that the transport releases meanwhile on this
/// thread end with this object, after the lock. One of them may be a message, and its destructor is user code, which
/// may publish or wait for another thread that does.
///
///     EndsLater after_the_lock;
///     const std::scoped_lock lock(mutex_);
///     outbound_->Commit(head, data);
///
/// Thread safety: none; it belongs to the thread that made it.
/// Invariants: they nest. Objects kept by an inner one pass to the outer one, whose lock may be held.
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
