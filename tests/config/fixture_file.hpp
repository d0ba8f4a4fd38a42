#pragma once

#include <filesystem>
#include <string_view>

#include "support/path.hpp"

namespace hgros::test {

/// A file in tests/config/yaml.
inline std::filesystem::path FixtureFile(std::string_view name) {
  return std::filesystem::path(Path("fixtures")) / name;
}

}  // namespace hgros::test
