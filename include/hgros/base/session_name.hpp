#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "hgros/base/export.hpp"

namespace hgros {

/// A session as logs, errors and commands name it: "talker:4711", its name and the id of its process; with "@robot"
/// behind it if `host` is given and is not this one.
[[nodiscard]] HGROS_EXPORT std::string SessionName(std::string_view process, std::int64_t pid,
                                                   std::string_view host = {});

}  // namespace hgros
