#pragma once

#include <string>

namespace hgros::viewer {

/// A sentence about what is wrong, over as many lines as it takes.
void DrawWarning(const std::string& text);
/// A sentence that explains, in grey.
void DrawNote(const std::string& text);

}  // namespace hgros::viewer
