#pragma once

#include <epoxy/gl.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace hgros::viewer {

/// The bytes of a pixel of a 2D texture: red, green, blue and alpha, before any swizzle. Reads it back from the GPU.
[[nodiscard]] std::array<std::uint8_t, 4> TexturePixel(GLuint texture, std::size_t x, std::size_t y);

}  // namespace hgros::viewer
