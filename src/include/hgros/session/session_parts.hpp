#pragma once

#include <memory>
#include <string_view>

#include "hgros/session/session.hpp"

namespace hgros {

// For code that is built on a session and may exist in it only once.
//
// Thread safety: all functions.
class SessionParts {
 public:
  explicit SessionParts(Session& session) : session_(session) {}

  // Reserves a name until the result is destroyed. Null if it is taken.
  [[nodiscard]] std::shared_ptr<const void> TryReserve(std::string_view name) { return session_.TryReserve(name); }
  [[nodiscard]] SessionCore& core() noexcept { return *session_.core_; }

 private:
  Session& session_;
};

}  // namespace hgros
