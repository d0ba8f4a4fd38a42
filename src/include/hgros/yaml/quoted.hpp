#pragma once

#include <string>
#include <string_view>

namespace hgros::yaml {

/// `text` in quotes for an error: shortened, control characters escaped.
[[nodiscard]] std::string Quoted(std::string_view text);

}  // namespace hgros::yaml
