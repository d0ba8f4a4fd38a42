#pragma once

#include "hgros/base/publish_status.hpp"
#include "hgros/codec/type_info.hpp"

namespace hgros {

/// A channel's way out of the process. This is all that the graph knows about the network.
///
/// Contract: if wanted(), a publish calls Reserve(); after kOk exactly one of Commit() and Cancel() follows.
/// Thread-safe; none of the calls blocks or runs user code.
class Outlet {
 public:
  virtual ~Outlet() = default;
  /// Somebody outside wants the next message. Cheap: called for every one.
  [[nodiscard]] virtual bool wanted() const noexcept = 0;
  /// `message` is of `type`, as later for Commit().
  virtual PublishStatus Reserve(const void* message, const TypeInfo& type) noexcept = 0;
  /// `message` is of `type`, which is one of those that the channel is used with.
  virtual void Commit(const AnyMessage& message, const TypeInfo& type) noexcept = 0;
  virtual void Cancel() noexcept = 0;
};

}  // namespace hgros
