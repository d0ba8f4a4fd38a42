#pragma once

#include <vector>

#include "hgros/base/error.hpp"

namespace hgros::yaml {

/// What a reader does with faults: it throws the first, or keeps all and reads on without the values that are wrong.
class Faults {
 public:
  Faults() = default;  ///< Throws.
  explicit Faults(std::vector<ConfigError>& kept) : kept_(&kept) {}

  void Report(const ConfigError& fault) const {
    if (kept_ == nullptr) throw fault;
    kept_->push_back(fault);
  }
  /// Runs `read` and reports the ConfigError that it throws. Returns whether there was none.
  template <typename Read>
  bool Attempt(Read read) const {
    if (kept_ == nullptr) {
      read();
      return true;
    }
    try {
      read();
      return true;
    } catch (const ConfigError& fault) {
      kept_->push_back(fault);
      return false;
    }
  }

 private:
  std::vector<ConfigError>* kept_ = nullptr;
};

}  // namespace hgros::yaml
