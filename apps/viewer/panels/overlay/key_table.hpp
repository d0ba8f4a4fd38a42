#pragma once

#include <span>

#include "viewer/view/navigation.hpp"

namespace hgros::viewer {

/// A key and its effect. Letters are upper case; other keys have our own numbers above 255.
enum SpecialKey { kKeyLeft = 256, kKeyRight, kKeyUp, kKeyDown, kKeyHome, kKeyF1, kKeyF12, kKeyEscape };

enum class ViewerKey {
  kNone,
  kHelp,
  kPause,
  kScreenshot,
  kFocus,
  kPanels,
  kOnePanel,
  kSaveLayout,
  kStep,
  kPick,
  kForget
};

struct KeyRow {
  int key;
  CameraKey camera;
  ViewerKey viewer;  ///< kNone: the key moves the camera.
  const char* name;
  const char* meaning;
};

/// All keys, in the order of the help.
[[nodiscard]] std::span<const KeyRow> KeyTable();

}  // namespace hgros::viewer
