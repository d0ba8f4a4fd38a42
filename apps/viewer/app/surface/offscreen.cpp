#include "viewer/app/surface/offscreen.hpp"

#include <epoxy/egl.h>
#include <imgui.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <string>

#include "hgros/base/error.hpp"

namespace hgros::viewer {
namespace {

double MonotonicS() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

/// The EGL display stays open: other contexts of the process may use it.
struct Offscreen::Egl {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  GLuint framebuffer = 0;
  GLuint color = 0;
};

Offscreen::Offscreen(const Viewport& size) : size_(size), egl_(std::make_unique<Egl>()) {
  egl_->display = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (egl_->display == EGL_NO_DISPLAY || eglInitialize(egl_->display, nullptr, nullptr) == EGL_FALSE) {
    throw Error("There is no EGL for drawing without a window. Install Debian's libegl1 and libgl1-mesa-dri.");
  }
  if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) throw Error("This EGL does not support OpenGL.");
  const EGLint attributes[] = {
      EGL_CONTEXT_MAJOR_VERSION,           3,       EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
      EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
  egl_->context = eglCreateContext(egl_->display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
  if (egl_->context == EGL_NO_CONTEXT) throw Error("This machine's OpenGL is older than 3.3.");
  eglMakeCurrent(egl_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl_->context);
  glGenFramebuffers(1, &egl_->framebuffer);
  glGenRenderbuffers(1, &egl_->color);
  glBindRenderbuffer(GL_RENDERBUFFER, egl_->color);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, size.width, size.height);
  glBindFramebuffer(GL_FRAMEBUFFER, egl_->framebuffer);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, egl_->color);
  wake_descriptor_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (wake_descriptor_ < 0) throw Error(std::string("An eventfd cannot be created: ") + std::strerror(errno) + ".");
}

Offscreen::~Offscreen() {
  close(wake_descriptor_);
  eglMakeCurrent(egl_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(egl_->display, egl_->context);
}

void Offscreen::Wait(double seconds) {
  pollfd wait{wake_descriptor_, POLLIN, 0};
  timespec timeout{};
  if (std::isfinite(seconds)) {
    timeout.tv_sec = static_cast<std::time_t>(seconds);
    timeout.tv_nsec = static_cast<long>((seconds - std::floor(seconds)) * 1e9);
  }
  if (ppoll(&wait, 1, std::isfinite(seconds) ? &timeout : nullptr, nullptr) <= 0) return;
  std::uint64_t count = 0;
  [[maybe_unused]] const auto read_bytes = read(wake_descriptor_, &count, sizeof count);
}

void Offscreen::Wake() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = write(wake_descriptor_, &one, sizeof one);
}

void Offscreen::BeginPanels() {
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(size_.width), static_cast<float>(size_.height)};
  io.DisplayFramebufferScale = {1, 1};
  const double now = MonotonicS();
  io.DeltaTime = static_cast<float>(panels_s_ > 0 ? std::max(now - panels_s_, 1e-4) : 1.0 / 60);
  panels_s_ = now;
}

GLuint Offscreen::framebuffer() const { return egl_->framebuffer; }

void Offscreen::Present() { glFinish(); }

}  // namespace hgros::viewer
