#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include "viewer/scene/gl_object.hpp"

namespace hgros::viewer {

/// GPU memory for what comes, is drawn for a while and is then replaced as a whole. Where the driver can, the memory
/// stays mapped and is written in place; elsewhere (OpenGL 3.3 alone) what was written is copied into it.
/// Thread: the one whose GL context is current, also at its end.
class StreamBuffer {
 public:
  enum class Way : std::uint8_t { kMapped, kCopied };
  /// The best one that the current context can.
  [[nodiscard]] static Way BestWay();
  /// Whether GL has done all that it was told before, without waiting for it.
  [[nodiscard]] static bool HasPassed(GLsync fence);

  explicit StreamBuffer(bool (*has_passed)(GLsync fence) = HasPassed) : has_passed_(has_passed) {}

  /// `fill` gets memory for `count` of T, to be written in full and not to be read; if that is none, nothing is done.
  /// Never waits, and never changes what GL may still draw: unless it was retired and that has been drawn, this is
  /// other memory than the last time.
  template <class T, std::invocable<std::span<T>> Fill>
  requires std::is_trivially_copyable_v<T>
  void Write(Way way, std::size_t count, Fill&& fill) {
    if (count == 0) return;
    if (way == Way::kMapped) {
      if (void* const mapped = MapFor(count * sizeof(T))) return fill(std::span(static_cast<T*>(mapped), count));
    }
    std::vector<T> values(count);
    fill(std::span(values));
    Copy(values.data(), count * sizeof(T));
  }
  /// All that draws from it has been told to GL, until it is written again.
  void Retire();

  [[nodiscard]] GLuint name() const noexcept { return buffer_.name(); }
  [[nodiscard]] std::size_t capacity_bytes() const noexcept { return capacity_; }

 private:
  struct DeleteSync {
    void operator()(GLsync sync) const noexcept { glDeleteSync(sync); }
  };
  using GlSync = std::unique_ptr<std::remove_pointer_t<GLsync>, DeleteSync>;

  [[nodiscard]] bool Fits(std::size_t size_bytes) const noexcept;
  /// Null: GL would not map it.
  [[nodiscard]] void* MapFor(std::size_t size_bytes);
  void Copy(const void* values, std::size_t size_bytes);

  bool (*has_passed_)(GLsync fence);
  GlBuffer buffer_;
  std::size_t capacity_ = 0;
  void* mapped_ = nullptr;  ///< For as long as the buffer lives.
  GlSync retired_;          ///< A fence behind the last draw; null: somebody may go on drawing.
};

}  // namespace hgros::viewer
