#pragma once

#include <epoxy/gl.h>

#include <utility>

namespace hgros::viewer {

/// Owns one GL object; move-only. Thread: the one whose GL context is current, also for the destructor. `Make` and
/// `Delete` are glGen... and glDelete... for one name.
template <void (*Make)(GLuint*), void (*Delete)(const GLuint*)>
class GlObject {
 public:
  /// 0: no object yet.
  GlObject() = default;
  [[nodiscard]] static GlObject New() {
    GlObject object;
    Make(&object.name_);
    return object;
  }
  GlObject(GlObject&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  ~GlObject() {
    if (name_ != 0) Delete(&name_);
  }

  [[nodiscard]] GLuint name() const noexcept { return name_; }
  [[nodiscard]] explicit operator bool() const noexcept { return name_ != 0; }

 private:
  GLuint name_ = 0;
};

namespace gl {
inline void MakeBuffer(GLuint* name) { glGenBuffers(1, name); }
inline void DeleteBuffer(const GLuint* name) { glDeleteBuffers(1, name); }
inline void MakeVertexArray(GLuint* name) { glGenVertexArrays(1, name); }
inline void DeleteVertexArray(const GLuint* name) { glDeleteVertexArrays(1, name); }
inline void MakeTexture(GLuint* name) { glGenTextures(1, name); }
inline void DeleteTexture(const GLuint* name) { glDeleteTextures(1, name); }
inline void MakeFramebuffer(GLuint* name) { glGenFramebuffers(1, name); }
inline void DeleteFramebuffer(const GLuint* name) { glDeleteFramebuffers(1, name); }
inline void MakeRenderbuffer(GLuint* name) { glGenRenderbuffers(1, name); }
inline void DeleteRenderbuffer(const GLuint* name) { glDeleteRenderbuffers(1, name); }
}  // namespace gl

using GlBuffer = GlObject<gl::MakeBuffer, gl::DeleteBuffer>;
using GlVertexArray = GlObject<gl::MakeVertexArray, gl::DeleteVertexArray>;
using GlTexture = GlObject<gl::MakeTexture, gl::DeleteTexture>;
using GlFramebuffer = GlObject<gl::MakeFramebuffer, gl::DeleteFramebuffer>;
using GlRenderbuffer = GlObject<gl::MakeRenderbuffer, gl::DeleteRenderbuffer>;

}  // namespace hgros::viewer
