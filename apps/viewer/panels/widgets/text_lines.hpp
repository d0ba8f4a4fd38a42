#pragma once

#include <string>

namespace hgros::viewer {

/// A sentence about an error, wrapped.
void DrawWarning(const std::string& text);
/// Text has the error color until ImGui::PopStyleColor.
void PushWarningColor();
/// A wrapped tooltip.
void DrawTooltip(const std::string& text);
/// An explaining sentence, in gray.
void DrawNote(const std::string& text);

/// Puts the next item on the same line if there is enough space.
void SameLineFor(const std::string& text);

}  // namespace hgros::viewer
