#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "viewer/app/layout.hpp"

namespace hgros::viewer {

/// Reads what LayoutText writes, or a person. Throws ConfigError with line and a way to mend it.
[[nodiscard]] Layout ParseLayout(std::string_view text, const std::string& name);
/// Likewise from a file.
[[nodiscard]] Layout LoadLayout(const std::filesystem::path& file);

/// As YAML, in an order and with names that people can read and change. A camera that could not be read again is left
/// out.
[[nodiscard]] std::string LayoutText(const Layout& layout);
/// The file is there whole or not at all. Returns what went wrong, or nothing.
[[nodiscard]] std::string SaveLayout(const Layout& layout, const std::filesystem::path& file);

}  // namespace hgros::viewer
