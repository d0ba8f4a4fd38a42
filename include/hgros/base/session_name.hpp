#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "hgros/base/export.hpp"
#include "hgros/base/ids.hpp"

namespace hgros {

/// A session as logs and errors name it: "0123456789abcdef (talker, process 42 on robot)"; without " on robot" if
/// `host` is empty.
[[nodiscard]] HGROS_EXPORT std::string SessionName(SessionId id, std::string_view process, std::int64_t pid,
                                                   std::string_view host = {});

}  // namespace hgros
