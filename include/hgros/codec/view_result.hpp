#pragma once

#include <optional>
#include <string>
#include <utility>

namespace hgros {

/// A view of a message's bytes, or one sentence that says why there is none: a message may describe its bytes
/// incorrectly.
///
///     const auto points = ViewPoints(cloud);
///     if (!points) return Complain(points.fault());
template <class View>
class ViewResult {
 public:
  ViewResult(View view) : view_(std::move(view)) {}  // NOLINT(google-explicit-constructor): it is the view.
  [[nodiscard]] static ViewResult Fault(std::string sentence) {
    ViewResult result;
    result.fault_ = std::move(sentence);
    return result;
  }

  [[nodiscard]] explicit operator bool() const noexcept { return view_.has_value(); }
  /// Throws std::bad_optional_access if there is none.
  [[nodiscard]] const View& operator*() const& { return view_.value(); }
  [[nodiscard]] View operator*() && { return std::move(view_).value(); }  ///< By value, for `for (... : *Make())`.
  [[nodiscard]] const View* operator->() const { return &view_.value(); }
  /// The reason; empty if there is a view.
  [[nodiscard]] const std::string& fault() const noexcept { return fault_; }

 private:
  ViewResult() = default;
  std::optional<View> view_;
  std::string fault_;
};

}  // namespace hgros
