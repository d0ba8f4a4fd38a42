#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "viewer/app/layout/layout.hpp"

namespace hgros::viewer {

/// Reads a layout that LayoutText or a user has written. Errors: throws ConfigError with the line and how to fix it.
[[nodiscard]] Layout ParseLayout(std::string_view text, const std::string& name);
/// The same from a file.
[[nodiscard]] Layout LoadLayout(const std::filesystem::path& file);

/// The layout as YAML that users can read and edit. A camera that could not be read back is left out.
[[nodiscard]] std::string LayoutText(const Layout& layout);
/// Writes the file completely or not at all. Returns what went wrong, or nothing.
[[nodiscard]] std::string SaveLayout(const Layout& layout, const std::filesystem::path& file);

}  // namespace hgros::viewer
