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

/// Gets the transform, or why it cannot come any more.
using TransformCallback = std::function<void(const TransformResult& result)>;

/// Holds a wait for a transform. Thread safety: as a value. It may outlive the tree.
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

  /// No callback begins afterwards; one in flight on another thread has returned.
  void Cancel();
  /// Neither called nor cancelled yet.
  [[nodiscard]] bool pending() const noexcept;

 private:
  std::weak_ptr<tf::Waits> waits_;
  std::shared_ptr<tf::Waiter> waiter_;
};

}  // namespace hgros
