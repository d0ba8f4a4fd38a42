#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace hgros::viewer {

/// All bytes of a regular file. None if it cannot be read, or is something else, such as a folder or a pipe.
[[nodiscard]] std::optional<std::string> ReadWholeFile(const std::filesystem::path& path);

}  // namespace hgros::viewer
