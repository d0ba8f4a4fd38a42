#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/tf/rigid_transform.hpp"

namespace hgros {

namespace tf {
class TreeCore;
}

struct StampedTransform {
  RigidTransform T_target_source;
  Time stamp;  ///< The time at which it holds. Time{} if only static edges connect the frames.
};

/// Why there is no transform.
enum class TransformFault : std::uint8_t {
  kNone,
  kUnknownFrame,  ///< No edge has a frame of this name.
  kNotConnected,  ///< Both frames are known, but in separate trees.
  kTooOld,        ///< Before the oldest transform of an edge.
  kTooNew,        ///< After the newest transform of an edge.
  kTimeout,       ///< A wait timed out.
  kStopped,       ///< A wait was stopped.
};

/// Details of a failed lookup. Fields that do not belong to the fault are empty.
struct TransformFailure {
  TransformFault fault = TransformFault::kNone;
  std::string text;          ///< One sentence with the frames, the edge and the times.
  std::string nearest_name;  ///< kUnknownFrame: the most similar known name, if one is similar.
  std::string target_root;   ///< kNotConnected.
  std::string source_root;   ///< kNotConnected.
  std::string edge_parent;   ///< kTooOld, kTooNew: the edge that decided it.
  std::string edge_child;
  Time oldest;  ///< kTooOld, kTooNew: the range of that edge.
  Time newest;
};

/// A transform, or the reason why there is none.
///
///     const auto result = tree.Lookup("map", "laser", stamp);
///     if (!result) return Complain(result.text());
///     Use(result->T_target_source);
class HGROS_EXPORT TransformResult {
 public:
  TransformResult(const StampedTransform& found) : found_(found) {}  // NOLINT(google-explicit-constructor)
  [[nodiscard]] static TransformResult Failed(TransformFailure failure);

  [[nodiscard]] explicit operator bool() const noexcept { return failure_ == nullptr; }
  /// Errors: throws Error with text() if there is no transform.
  [[nodiscard]] const StampedTransform& operator*() const {
    if (failure_) Throw();
    return found_;
  }
  [[nodiscard]] const StampedTransform* operator->() const { return &**this; }

  [[nodiscard]] TransformFault fault() const noexcept { return failure_ ? failure_->fault : TransformFault::kNone; }
  /// Empty if there is a transform.
  [[nodiscard]] const std::string& text() const noexcept { return failure().text; }
  [[nodiscard]] const TransformFailure& failure() const noexcept;

 private:
  friend class tf::TreeCore;
  TransformResult() = default;
  explicit TransformResult(std::shared_ptr<const TransformFailure> failure) : failure_(std::move(failure)) {}
  [[noreturn]] void Throw() const;

  StampedTransform found_;
  std::shared_ptr<const TransformFailure> failure_;
};

/// Why a transform was refused.
enum class SetFault : std::uint8_t {
  kNone,
  kName,           ///< Empty, or not usable as a name.
  kRotation,       ///< Not of unit length (more than 0.1 % off), or not a number.
  kTranslation,    ///< Not a finite number, or above 1e12 m.
  kCycle,          ///< The parent is a descendant of the child.
  kTwoParents,     ///< The child already has another parent.
  kStatic,         ///< A static edge was set with a stamp, or a moving one without.
  kTooOld,         ///< Its stamp is before the range of the edge's buffer.
  kTooNew,         ///< Its stamp is too far ahead of the session's clock: see TransformsOptions::max_ahead.
  kTooManyFrames,  ///< It would exceed TransformTreeOptions::max_frames.
  kTooDeep,        ///< A frame would be more than 1000 edges below its root.
};

/// Whether a transform was stored.
class SetResult {
 public:
  SetResult() = default;
  SetResult(SetFault fault, std::string sentence) : fault_(fault), text_(std::move(sentence)) {}
  [[nodiscard]] static SetResult Stored(bool jumped_back) {
    SetResult result;
    result.jumped_back_ = jumped_back;
    return result;
  }
  [[nodiscard]] explicit operator bool() const noexcept { return fault_ == SetFault::kNone; }
  /// The stamps of the edge have jumped back: the transform has replaced all others of the edge.
  [[nodiscard]] bool jumped_back() const noexcept { return jumped_back_; }
  [[nodiscard]] SetFault fault() const noexcept { return fault_; }
  /// One sentence that names the edge; empty if the transform was stored.
  [[nodiscard]] const std::string& text() const noexcept { return text_; }

 private:
  SetFault fault_ = SetFault::kNone;
  bool jumped_back_ = false;
  std::string text_;
};

}  // namespace hgros
