#pragma once

namespace hgros {

// Marks the calling thread as running a callback of `node` in `graph`. Scopes nest: an inline callback that publishes
// runs other callbacks inside it.
class CallbackScope {
 public:
  CallbackScope(const void* graph, const void* node) noexcept;
  CallbackScope(const CallbackScope&) = delete;
  CallbackScope& operator=(const CallbackScope&) = delete;
  ~CallbackScope();

  [[nodiscard]] static bool InAny() noexcept;
  [[nodiscard]] static bool InGraph(const void* graph) noexcept;
  [[nodiscard]] static bool InNode(const void* node) noexcept;

 private:
  const void* graph_;
  const void* node_;
  CallbackScope* outer_;
};

}  // namespace hgros
