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
  Time stamp;  ///< When it held. Time{} where it always does: nothing but static edges lies between the frames.
};

/// Why there is no transform.
enum class TransformFault : std::uint8_t {
  kNone,
  kUnknownFrame,  ///< No edge has a frame of that name.
  kNotConnected,  ///< Both frames are known, in two trees.
  kTooOld,        ///< Before what some edge still remembers.
  kTooNew,        ///< After the newest that some edge knows.
  kTimeout,       ///< A wait has ended without it.
  kStopped,       ///< A wait was stopped.
};

/// What there is to say of a transform that is not there. Fields that do not belong to the fault are empty.
struct TransformFailure {
  TransformFault fault = TransformFault::kNone;
  std::string text;          ///< A sentence with the frames, the edge and the times.
  std::string nearest_name;  ///< kUnknownFrame: the known frame with the most similar name, if one is similar.
  std::string target_root;   ///< kNotConnected.
  std::string source_root;   ///< kNotConnected.
  std::string edge_parent;   ///< kTooOld, kTooNew: the edge that decides.
  std::string edge_child;
  Time oldest;  ///< kTooOld, kTooNew: what that edge has.
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
  /// Errors: throws Error with text() if there is none.
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

/// Why a transform was not taken.
enum class SetFault : std::uint8_t {
  kNone,
  kName,           ///< Empty, or not fit for a name.
  kRotation,       ///< Not of unit length (more than 0.1 % off), or not a number.
  kTranslation,    ///< Not a finite number.
  kCycle,          ///< The parent hangs below the child.
  kTwoParents,     ///< The child hangs below another parent already.
  kStatic,         ///< The edge is static and was set with a stamp, or the other way round.
  kTooOld,         ///< Its stamp lies before what the edge's buffer keeps.
  kTooManyFrames,  ///< It would bring a frame more than TransformTreeOptions::max_frames.
};

/// Whether a transform was taken.
class SetResult {
 public:
  SetResult() = default;
  SetResult(SetFault fault, std::string sentence) : fault_(fault), text_(std::move(sentence)) {}
  [[nodiscard]] explicit operator bool() const noexcept { return fault_ == SetFault::kNone; }
  [[nodiscard]] SetFault fault() const noexcept { return fault_; }
  /// A sentence that names the edge; empty if it was taken.
  [[nodiscard]] const std::string& text() const noexcept { return text_; }

 private:
  SetFault fault_ = SetFault::kNone;
  std::string text_;
};

}  // namespace hgros
