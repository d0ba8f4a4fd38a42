#pragma once

#include <span>
#include <string>
#include <string_view>

#include "arguments/command.hpp"

namespace hgros::cli {

/// The manual page (roff) of hgros as a whole.
[[nodiscard]] std::string ManualOfAll(std::string_view version, std::span<const CommandEntry> commands);
/// The manual page of one command or family.
[[nodiscard]] std::string ManualOf(std::string_view version, const CommandEntry& entry,
                                   std::span<const CommandEntry> commands);
/// "hgros-param-get", the name of that page.
[[nodiscard]] std::string ManualName(const CommandEntry& entry);

}  // namespace hgros::cli
