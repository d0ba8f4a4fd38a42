#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace hgros::cli {

/// A part of a unit's name: characters that systemd does not allow there become \xNN, as systemd-escape does. "-" stays
/// in that of a robot, except at its ends; in that of a unit it becomes \x2d, so that the two parts remain distinct.
[[nodiscard]] std::string EscapedRobotName(std::string_view name);
[[nodiscard]] std::string EscapedUnitName(std::string_view name);

/// One word of ExecStart or Environment: quoted if need be, so that systemd reads exactly `text`. Specifiers (%) are
/// escaped. In a command, also variables ($).
[[nodiscard]] std::string UnitWord(std::string_view text);
[[nodiscard]] std::string CommandWord(std::string_view text);
[[nodiscard]] std::string CommandLine(const std::vector<std::string>& words);

/// The rest of a line that systemd takes as it is, such as a Description: visible, with specifiers escaped.
[[nodiscard]] std::string UnitSentence(std::string_view text);

}  // namespace hgros::cli
