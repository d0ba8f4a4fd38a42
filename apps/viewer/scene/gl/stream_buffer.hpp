#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include "viewer/scene/gl/gl_object.hpp"

namespace hgros::viewer {

/// GPU memory for data that is drawn for a while and then replaced as a whole. If the driver supports it, the memory
/// stays mapped and is written in place. Otherwise (plain OpenGL 3.3) the data is copied. Thread: the one whose GL
/// context is current, also for the destructor.
class StreamBuffer {
 public:
  enum class Way : std::uint8_t { kMapped, kCopied };
  /// The best kind that the current context supports.
  [[nodiscard]] static Way BestWay();
  /// Whether GL has finished all earlier commands. Does not wait.
  [[nodiscard]] static bool HasPassed(GLsync fence);

  explicit StreamBuffer(bool (*has_passed)(GLsync fence) = HasPassed) : has_passed_(has_passed) {}

  /// `fill` gets memory for `count` of T, which it must write completely and must not read. Does nothing if `count` is
  /// 0. Never waits, and never changes data that GL may still draw: it uses new memory unless the old memory was
  /// retired and its drawing is finished.
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
  /// Call it after the last draw call that reads the current contents.
  void Retire();

  [[nodiscard]] GLuint name() const noexcept { return buffer_.name(); }
  [[nodiscard]] std::size_t capacity_bytes() const noexcept { return capacity_; }

 private:
  struct DeleteSync {
    void operator()(GLsync sync) const noexcept { glDeleteSync(sync); }
  };
  using GlSync = std::unique_ptr<std::remove_pointer_t<GLsync>, DeleteSync>;

  [[nodiscard]] bool Fits(std::size_t size_bytes) const noexcept;
  /// Null if GL cannot map it.
  [[nodiscard]] void* MapFor(std::size_t size_bytes);
  void Copy(const void* values, std::size_t size_bytes);

  bool (*has_passed_)(GLsync fence);
  GlBuffer buffer_;
  std::size_t capacity_ = 0;
  void* mapped_ = nullptr;  ///< As long as the buffer exists.
  GlSync retired_;          ///< A fence after the last draw; null: more drawing may follow.
};

}  // namespace hgros::viewer
