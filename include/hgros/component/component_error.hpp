#pragma once

#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/base/export.hpp"

namespace hgros {

/// A component cannot be made from its setup. what() has all faults, one after the other.
class HGROS_EXPORT ComponentError : public Error {
 public:
  /// At least one. Each names the component, and where() is the place of the value if it has one.
  explicit ComponentError(std::vector<Error> faults);

  [[nodiscard]] const std::vector<Error>& faults() const noexcept { return faults_; }

 private:
  std::vector<Error> faults_;
};

}  // namespace hgros
