#pragma once

#include <filesystem>

namespace hgros::viewer {

/// The name itself if there is no such file, or else the first free one of "name-2.ending", "name-3.ending" and so on.
[[nodiscard]] std::filesystem::path FreeName(const std::filesystem::path& file);

}  // namespace hgros::viewer
