#include "viewer/scene/gl/software_renderer.hpp"

#include <epoxy/gl.h>

#include <string_view>

namespace hgros::viewer {
namespace {

bool DrawsInSoftware() {
  const auto* const name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  if (name == nullptr) return false;
  const std::string_view renderer(name);
  return renderer.find("llvmpipe") != renderer.npos || renderer.find("softpipe") != renderer.npos;
}

}  // namespace

void DrawnPoints::Count(std::size_t points) {
  waiting_ += points;
  if (waiting_ < kAtOnce) return;
  waiting_ = 0;
  if (DrawsInSoftware()) glFinish();
}

}  // namespace hgros::viewer
