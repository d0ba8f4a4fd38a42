#pragma once

#include <span>
#include <string>

#include "arguments/command.hpp"

namespace hgros::cli {

class Console;

/// The list of all commands, for `hgros help`.
[[nodiscard]] std::string HelpOfAll(const Console& console, std::span<const CommandEntry> commands);
/// The help of one command.
[[nodiscard]] std::string HelpOf(const Console& console, const CommandEntry& entry);
/// Its first line: "hgros echo CHANNEL... [OPTIONS]".
[[nodiscard]] std::string UsageOf(const CommandEntry& entry, const Arguments& arguments);

}  // namespace hgros::cli
