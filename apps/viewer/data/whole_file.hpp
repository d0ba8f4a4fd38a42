#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace hgros::viewer {

/// All bytes of a regular file; nothing of whatever else is there, such as a folder or a pipe, or if it cannot be read.
[[nodiscard]] std::optional<std::string> ReadWholeFile(const std::filesystem::path& path);

}  // namespace hgros::viewer
