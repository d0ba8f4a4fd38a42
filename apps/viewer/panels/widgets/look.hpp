#pragma once

#include <cstdint>

namespace hgros::viewer {

/// Which characters can be written. More need time and memory, so they are loaded when they are needed.
enum class Glyphs : std::uint8_t {
  kLatin,
  kFont,  ///< Those of the font, all up to U+FFFF: Debian's ImGui has characters of 16 bits.
  kAll,   ///< Also Chinese, Japanese and Korean, if a font for them is installed.
};

/// Sets ImGui's colors, sizes and font. `scale` is the number of screen pixels per pixel of the design.
void SetLook(float scale, Glyphs glyphs = Glyphs::kLatin);
/// Whether the output of ImGui::Render has a sign in place of a character that cannot be written.
[[nodiscard]] bool NeedsMoreGlyphs();

/// The color of errors and warnings.
struct WarningColor {
  static constexpr float kRgba[4] = {1.0F, 0.70F, 0.35F, 1.0F};
};

}  // namespace hgros::viewer
