#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "viewer/view/camera.hpp"

namespace hgros::viewer {

/// Writes rows from the top, 3 bytes a pixel. Writes the file completely or not at all. Returns what went wrong, or
/// nothing.
[[nodiscard]] std::string WritePng(const std::filesystem::path& file, const Viewport& size,
                                   std::span<const std::uint8_t> rgb);

}  // namespace hgros::viewer
