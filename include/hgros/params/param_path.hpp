#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "hgros/base/export.hpp"

namespace hgros {

/// The path from the root of the parameters to one of them: keys of maps, and positions in lists starting at 0. As
/// text: `slam.matcher.gains[2]`. A key is put in double quotes if it has characters other than letters, digits, "_",
/// "-" and "/".
class HGROS_EXPORT ParamPath {
 public:
  using Step = std::variant<std::string, std::size_t>;

  ParamPath() = default;
  explicit ParamPath(std::vector<Step> steps) : steps_(std::move(steps)) {}
  /// Throws ParamError naming the position of the error. An empty text is the root.
  [[nodiscard]] static ParamPath Parse(std::string_view text);

  [[nodiscard]] const std::vector<Step>& steps() const noexcept { return steps_; }
  [[nodiscard]] bool empty() const noexcept { return steps_.empty(); }
  [[nodiscard]] std::string ToString() const;
  [[nodiscard]] ParamPath Below(Step step) const;
  /// The two are equal or one contains the other.
  [[nodiscard]] bool Overlaps(const ParamPath& other) const;
  bool operator==(const ParamPath&) const = default;

 private:
  std::vector<Step> steps_;
};

}  // namespace hgros
