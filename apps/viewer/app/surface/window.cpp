#include "viewer/app/surface/window.hpp"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "hgros/base/error.hpp"
#include "viewer/panels/dock/panel_below.hpp"
#include "viewer/panels/overlay/key_table.hpp"

namespace hgros::viewer {
namespace {

std::string LastError() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text == nullptr ? "no reason was given" : text;
}

/// The key as in KeyRow; 0 for keys without a meaning.
int KeyOf(int glfw_key) {
  switch (glfw_key) {
    case GLFW_KEY_LEFT: return kKeyLeft;
    case GLFW_KEY_RIGHT: return kKeyRight;
    case GLFW_KEY_UP: return kKeyUp;
    case GLFW_KEY_DOWN: return kKeyDown;
    case GLFW_KEY_HOME: return kKeyHome;
    case GLFW_KEY_F1: return kKeyF1;
    case GLFW_KEY_F12: return kKeyF12;
    case GLFW_KEY_ESCAPE: return kKeyEscape;
    default: return glfw_key < 256 ? glfw_key : 0;
  }
}

Window& WindowOf(GLFWwindow* window) { return *static_cast<Window*>(glfwGetWindowUserPointer(window)); }

}  // namespace

Window::Window(const std::string& title, const Viewport& size) {
  if (glfwInit() == GLFW_FALSE) {
    throw Error("No window can be opened: " + LastError() + ". Without a screen, --offscreen draws into memory.");
  }
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  glfwWindowHintString(GLFW_X11_CLASS_NAME, "hgros-viewer");
  window_ = glfwCreateWindow(size.width, size.height, title.c_str(), nullptr, nullptr);
  if (window_ == nullptr) {
    const std::string why = LastError();
    glfwTerminate();
    throw Error("No window can be opened: " + why + ". Without a screen, --offscreen draws into memory.");
  }
  glfwSetWindowUserPointer(window_, this);
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(0);  // The viewer limits the frame rate itself.
  float scale_y = 1;
  glfwGetWindowContentScale(window_, &scale_, &scale_y);
  scale_ = std::max(1.0F, scale_);
  tells_loss_ = glfwGetWindowAttrib(window_, GLFW_CONTEXT_ROBUSTNESS) == GLFW_LOSE_CONTEXT_ON_RESET &&
                epoxy_has_gl_extension("GL_ARB_robustness");
  InstallCallbacks();
}

Window::~Window() {
  if (panels_connected_) ImGui_ImplGlfw_Shutdown();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

void Window::InstallCallbacks() {
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* at, int button, int action, int mods) {
    Window& window = WindowOf(at);
    window.disturbed_ = true;
    if (window.panels_connected_) ImGui_ImplGlfw_MouseButtonCallback(at, button, action, mods);
    const bool release = action == GLFW_RELEASE;
    if (!release && window.OverPanel()) return;
    const PointerButton which = button == GLFW_MOUSE_BUTTON_LEFT    ? PointerButton::kLeft
                                : button == GLFW_MOUSE_BUTTON_RIGHT ? PointerButton::kRight
                                                                    : PointerButton::kMiddle;
    window.input_.push_back({release ? InputEvent::Kind::kRelease : InputEvent::Kind::kPress, which, window.x_,
                             window.y_, 0, 0, (mods & GLFW_MOD_SHIFT) != 0});
  });
  glfwSetCursorPosCallback(window_, [](GLFWwindow* at, double x, double y) {
    Window& window = WindowOf(at);
    window.disturbed_ = true;
    window.x_ = x * window.PixelsPerUnit();
    window.y_ = y * window.PixelsPerUnit();
    window.input_.push_back({InputEvent::Kind::kPointer, {}, window.x_, window.y_});
  });
  glfwSetScrollCallback(window_, [](GLFWwindow* at, double dx, double dy) {
    Window& window = WindowOf(at);
    window.disturbed_ = true;
    if (window.panels_connected_) {
      ImGui_ImplGlfw_ScrollCallback(at, dx, dy);
      if (window.OverPanel()) return;
    }
    window.input_.push_back({InputEvent::Kind::kWheel, {}, window.x_, window.y_, dy});
  });
  glfwSetKeyCallback(window_, [](GLFWwindow* at, int key, int scancode, int action, int mods) {
    Window& window = WindowOf(at);
    window.disturbed_ = true;
    if (window.panels_connected_) ImGui_ImplGlfw_KeyCallback(at, key, scancode, action, mods);
    window.OnKey(key, action);
  });
  glfwSetCharCallback(window_, [](GLFWwindow* at, unsigned character) {
    if (WindowOf(at).panels_connected_) ImGui_ImplGlfw_CharCallback(at, character);
  });
  glfwSetCursorEnterCallback(window_, [](GLFWwindow* at, int entered) {
    WindowOf(at).disturbed_ = true;
    if (WindowOf(at).panels_connected_) ImGui_ImplGlfw_CursorEnterCallback(at, entered);
  });
  glfwSetWindowFocusCallback(window_, [](GLFWwindow* at, int focused) {
    WindowOf(at).disturbed_ = true;
    if (WindowOf(at).panels_connected_) ImGui_ImplGlfw_WindowFocusCallback(at, focused);
  });
  glfwSetWindowContentScaleCallback(window_, [](GLFWwindow* at, float x, float) {
    WindowOf(at).scale_ = std::max(1.0F, x);
    WindowOf(at).disturbed_ = true;
  });
  glfwSetFramebufferSizeCallback(window_, [](GLFWwindow* at, int, int) { WindowOf(at).disturbed_ = true; });
  glfwSetWindowRefreshCallback(window_, [](GLFWwindow* at) { WindowOf(at).disturbed_ = true; });
  glfwSetWindowIconifyCallback(window_, [](GLFWwindow* at, int) { WindowOf(at).disturbed_ = true; });
}

void Window::OnKey(int key, int action) {
  if (action == GLFW_RELEASE) return;
  if (panels_connected_ && ImGui::GetIO().WantTextInput) return;
  const int known = KeyOf(key);
  if (known != 0) input_.push_back({InputEvent::Kind::kKey, {}, x_, y_, 0, known});
}

bool Window::OverPanel() const {
  if (!panels_connected_) return false;
  const double scale = PixelsPerUnit();
  return PanelBelow(static_cast<float>(x_ / scale), static_cast<float>(y_ / scale));
}

double Window::PixelsPerUnit() const {
  int window_width = 1;
  int width = 1;
  int height = 1;
  glfwGetWindowSize(window_, &window_width, &height);
  glfwGetFramebufferSize(window_, &width, &height);
  return window_width > 0 ? static_cast<double>(width) / window_width : 1;
}

void Window::ConnectPanels() {
  ImGui_ImplGlfw_InitForOpenGL(window_, false);
  panels_connected_ = true;
}

void Window::Wait(double seconds) {
  if (seconds <= 0) {
    glfwPollEvents();
  } else if (std::isfinite(seconds)) {
    glfwWaitEventsTimeout(seconds);
  } else {
    glfwWaitEvents();
  }
}

void Window::Wake() { glfwPostEmptyEvent(); }

bool Window::TakeDisturbed() { return std::exchange(disturbed_, false); }

std::vector<InputEvent> Window::TakeInput() { return std::exchange(input_, {}); }

bool Window::hidden() const {
  const Viewport now = size();
  return glfwGetWindowAttrib(window_, GLFW_ICONIFIED) == GLFW_TRUE ||
         glfwGetWindowAttrib(window_, GLFW_VISIBLE) == GLFW_FALSE || now.width < 1 || now.height < 1;
}

bool Window::lost() const { return tells_loss_ && glGetGraphicsResetStatusARB() != GL_NO_ERROR; }

bool Window::closing() const { return glfwWindowShouldClose(window_) == GLFW_TRUE; }

Viewport Window::size() const {
  Viewport size;
  glfwGetFramebufferSize(window_, &size.width, &size.height);
  return size;
}

void Window::BeginPanels() { ImGui_ImplGlfw_NewFrame(); }

void Window::Present() { glfwSwapBuffers(window_); }

}  // namespace hgros::viewer
