#pragma once

#include <functional>
#include <memory>

#include "hgros/base/export.hpp"
#include "hgros/tf/transform_result.hpp"

namespace hgros {

namespace tf {
class Waits;
class Waiter;
}  // namespace tf

/// Gets the transform, or the reason why it can no longer come.
using TransformCallback = std::function<void(const TransformResult& result)>;

/// Keeps a wait for a transform; move-only. Thread safety: as a value. It may outlive the tree.
class HGROS_EXPORT PendingTransform {
 public:
  /// Waits for nothing.
  PendingTransform() = default;
  PendingTransform(std::weak_ptr<tf::Waits> waits, std::shared_ptr<tf::Waiter> waiter);
  PendingTransform(PendingTransform&& other) noexcept = default;
  PendingTransform& operator=(PendingTransform&& other) noexcept;
  PendingTransform(const PendingTransform&) = delete;
  PendingTransform& operator=(const PendingTransform&) = delete;
  ~PendingTransform();

  /// After it returns, no callback starts, and a callback that ran on another thread has returned.
  void Cancel();
  /// Whether the callback was neither called nor cancelled yet.
  [[nodiscard]] bool pending() const noexcept;

 private:
  std::weak_ptr<tf::Waits> waits_;
  std::shared_ptr<tf::Waiter> waiter_;
};

}  // namespace hgros
