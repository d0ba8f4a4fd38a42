#include "viewer/panels/key_table.hpp"

namespace hgros::viewer {
namespace {

constexpr KeyRow Camera(int key, CameraKey camera, const char* name, const char* meaning) {
  return {key, camera, ViewerKey::kNone, name, meaning};
}
constexpr KeyRow Viewer(int key, ViewerKey viewer, const char* name, const char* meaning) {
  return {key, CameraKey::kReset, viewer, name, meaning};
}

constexpr KeyRow kKeys[] = {
    Camera(kKeyLeft, CameraKey::kYawLeft, "Left", "turn about the anchor: yaw"),
    Camera(kKeyRight, CameraKey::kYawRight, "Right", nullptr),
    Camera(kKeyUp, CameraKey::kPitchUp, "Up", "turn about the anchor: pitch"),
    Camera(kKeyDown, CameraKey::kPitchDown, "Down", nullptr),
    Camera('Q', CameraKey::kRollLeft, "Q", "turn about the anchor: roll"),
    Camera('E', CameraKey::kRollRight, "E", nullptr),
    Camera('W', CameraKey::kForward, "W", "move the anchor forward and back"),
    Camera('S', CameraKey::kBack, "S", nullptr),
    Camera('A', CameraKey::kLeft, "A", "move the anchor left and right"),
    Camera('D', CameraKey::kRight, "D", nullptr),
    Camera('R', CameraKey::kUp, "R", "move the anchor up and down"),
    Camera('F', CameraKey::kDown, "F", nullptr),
    Camera('C', CameraKey::kClearAnchor, "C", "clear the anchor"),
    Camera('T', CameraKey::kFromAbove, "T", "look from above, x to the right and y up"),
    Camera('O', CameraKey::kOrthographic, "O", "orthographic or perspective"),
    Viewer('Z', ViewerKey::kFocus, "Z", "show everything"),
    Camera(kKeyHome, CameraKey::kReset, "Home", "the view as at the start"),
    Viewer(' ', ViewerKey::kPause, "Space", "pause and go on"),
    Viewer('N', ViewerKey::kStep, "N", "show what has come until now, and stand still"),
    Viewer('M', ViewerKey::kPick, "M", "clicks pick points, and measure between two"),
    Viewer(kKeyEscape, ViewerKey::kForget, "Escape", "forget the points picked"),
    Viewer('P', ViewerKey::kPanels, "P", "panels on and off"),
    Viewer('1', ViewerKey::kOnePanel, "1", "channels, log, message, plot, graph: open and close"),
    Viewer('2', ViewerKey::kOnePanel, "2", nullptr),
    Viewer('3', ViewerKey::kOnePanel, "3", nullptr),
    Viewer('4', ViewerKey::kOnePanel, "4", nullptr),
    Viewer('5', ViewerKey::kOnePanel, "5", nullptr),
    Viewer('L', ViewerKey::kSaveLayout, "L", "write the layout file"),
    Viewer(kKeyF12, ViewerKey::kScreenshot, "F12", "write a screenshot"),
    Viewer(kKeyF1, ViewerKey::kHelp, "F1", "this help on and off"),
    Viewer('H', ViewerKey::kHelp, "H", nullptr),
};

}  // namespace

std::span<const KeyRow> KeyTable() { return kKeys; }

}  // namespace hgros::viewer
