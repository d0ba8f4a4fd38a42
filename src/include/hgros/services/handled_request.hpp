#pragma once

#include <chrono>
#include <optional>

#include "hgros/base/export.hpp"

namespace hgros {

// Marks this thread as handling a request while it lives, for a handler that lets the request wait. Marks nest.
class HandledRequest {
 public:
  using Due = std::optional<std::chrono::steady_clock::time_point>;

  explicit HandledRequest(Due due) noexcept;
  HandledRequest(const HandledRequest&) = delete;
  HandledRequest& operator=(const HandledRequest&) = delete;
  ~HandledRequest();

  // When the caller of the innermost one gives up; empty if it never does.
  [[nodiscard]] HGROS_EXPORT static Due DueHere() noexcept;

 private:
  const Due outer_;
};

// Thrown by such a handler: nobody has taken the request, because its caller has given up or the service has ended.
class HGROS_EXPORT NotHandled {};

}  // namespace hgros
