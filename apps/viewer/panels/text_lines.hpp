#pragma once

#include <string>

namespace hgros::viewer {

/// A sentence about what is wrong, over as many lines as it takes.
void DrawWarning(const std::string& text);
/// What is written until ImGui::PopStyleColor is wrong.
void PushWarningColor();
/// Beside the pointer, over as many lines as it takes.
void DrawTooltip(const std::string& text);
/// A sentence that explains, in grey.
void DrawNote(const std::string& text);

/// What comes next, a button or words, stands on the same line if there is room for it.
void SameLineFor(const std::string& text);

}  // namespace hgros::viewer
