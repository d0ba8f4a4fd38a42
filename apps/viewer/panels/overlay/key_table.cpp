#include "viewer/panels/overlay/key_table.hpp"

namespace hgros::viewer {
namespace {

constexpr KeyRow CameraRow(int key, CameraKey camera, const char* name, const char* meaning) {
  return {key, camera, ViewerKey::kNone, name, meaning};
}
constexpr KeyRow Viewer(int key, ViewerKey viewer, const char* name, const char* meaning) {
  return {key, CameraKey::kReset, viewer, name, meaning};
}

constexpr KeyRow kKeys[] = {
    CameraRow(kKeyLeft, CameraKey::kYawLeft, "Left", "turn around the anchor: yaw"),
    CameraRow(kKeyRight, CameraKey::kYawRight, "Right", nullptr),
    CameraRow(kKeyUp, CameraKey::kPitchUp, "Up", "turn around the anchor: pitch"),
    CameraRow(kKeyDown, CameraKey::kPitchDown, "Down", nullptr),
    CameraRow('Q', CameraKey::kRollLeft, "Q", "turn around the anchor: roll"),
    CameraRow('E', CameraKey::kRollRight, "E", nullptr),
    CameraRow('W', CameraKey::kForward, "W", "move the anchor forward and back"),
    CameraRow('S', CameraKey::kBack, "S", nullptr),
    CameraRow('A', CameraKey::kLeft, "A", "move the anchor left and right"),
    CameraRow('D', CameraKey::kRight, "D", nullptr),
    CameraRow('R', CameraKey::kUp, "R", "move the anchor up and down"),
    CameraRow('F', CameraKey::kDown, "F", nullptr),
    CameraRow('C', CameraKey::kClearAnchor, "C", "clear the anchor"),
    CameraRow('T', CameraKey::kFromAbove, "T", "look from above, x to the right and y up"),
    CameraRow('O', CameraKey::kOrthographic, "O", "orthographic or perspective"),
    Viewer('Z', ViewerKey::kFocus, "Z", "show everything"),
    CameraRow(kKeyHome, CameraKey::kReset, "Home", "reset the view"),
    Viewer(' ', ViewerKey::kPause, "Space", "pause or continue"),
    Viewer('N', ViewerKey::kStep, "N", "show what has arrived until now, and stay paused"),
    Viewer('M', ViewerKey::kPick, "M", "clicks pick points, and measure between two"),
    Viewer(kKeyEscape, ViewerKey::kForget, "Escape", "clear the picked points"),
    Viewer('P', ViewerKey::kPanels, "P", "panels on and off"),
    Viewer('1', ViewerKey::kOnePanel, "1", "channels, log, message, plot, graph: open and close"),
    Viewer('2', ViewerKey::kOnePanel, "2", nullptr),
    Viewer('3', ViewerKey::kOnePanel, "3", nullptr),
    Viewer('4', ViewerKey::kOnePanel, "4", nullptr),
    Viewer('5', ViewerKey::kOnePanel, "5", nullptr),
    Viewer('L', ViewerKey::kSaveLayout, "L", "write the layout file"),
    Viewer(kKeyF12, ViewerKey::kScreenshot, "F12", "save a screenshot"),
    Viewer(kKeyF1, ViewerKey::kHelp, "F1", "this help on and off"),
    Viewer('H', ViewerKey::kHelp, "H", nullptr),
};

}  // namespace

std::span<const KeyRow> KeyTable() { return kKeys; }

}  // namespace hgros::viewer
