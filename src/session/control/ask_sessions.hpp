#pragma once

#include <chrono>
#include <span>
#include <vector>

#include "hgros/services/service_place.hpp"
#include "hgros/session/session_control.hpp"

namespace hgros {

// As the function of session_control.hpp, for session `self`, of which `place` is a part.
[[nodiscard]] std::vector<ControlAnswer> AskSessions(ServicePlace& place, SessionId self,
                                                     std::span<const SessionId> sessions, const ControlOrder& order,
                                                     std::chrono::nanoseconds timeout);

}  // namespace hgros
