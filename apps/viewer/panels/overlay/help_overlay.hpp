#pragma once

namespace hgros::viewer {

/// A list of what mouse and keys do, in the middle of the window.
void DrawHelp(bool& open);

}  // namespace hgros::viewer
