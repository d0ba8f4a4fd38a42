#include "viewer/scene/gl/stream_buffer.hpp"

namespace hgros::viewer {

StreamBuffer::Way StreamBuffer::BestWay() {
  return epoxy_gl_version() >= 44 || epoxy_has_gl_extension("GL_ARB_buffer_storage") ? Way::kMapped : Way::kCopied;
}

bool StreamBuffer::Fits(std::size_t size_bytes) const noexcept {
  return buffer_ && size_bytes <= capacity_ && size_bytes * 4 >= capacity_;
}

bool StreamBuffer::HasPassed(GLsync fence) {
  const GLenum answer = glClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, 0);
  return answer == GL_ALREADY_SIGNALED || answer == GL_CONDITION_SATISFIED;
}

// Such storage has a fixed size, so a new size needs a new buffer. So does writing while the old contents may still be
// drawn.
void* StreamBuffer::MapFor(std::size_t size_bytes) {
  const bool drawn = retired_ && has_passed_(retired_.get());
  retired_.reset();
  if (mapped_ != nullptr && drawn && Fits(size_bytes)) return mapped_;
  constexpr GLbitfield kAccess = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
  const auto size = static_cast<GLsizeiptr>(size_bytes);
  buffer_ = GlBuffer::New();
  capacity_ = size_bytes;
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
  glBufferStorage(GL_ARRAY_BUFFER, size, nullptr, kAccess);
  mapped_ = glMapBufferRange(GL_ARRAY_BUFFER, 0, size, kAccess);
  if (mapped_ == nullptr) buffer_ = {};  // Its storage cannot be written in any other way.
  return mapped_;
}

// The old contents are orphaned, so that nobody waits until they are drawn.
void StreamBuffer::Copy(const void* values, std::size_t size_bytes) {
  if (!buffer_ || mapped_ != nullptr) {
    buffer_ = GlBuffer::New();
    mapped_ = nullptr;
    capacity_ = 0;
  }
  retired_.reset();
  if (!Fits(size_bytes)) capacity_ = size_bytes;
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(capacity_), nullptr, GL_STREAM_DRAW);
  glBufferSubData(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(size_bytes), values);
}

void StreamBuffer::Retire() {
  if (mapped_ != nullptr) retired_.reset(glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0));
}

}  // namespace hgros::viewer
