#pragma once

#include <filesystem>
#include <string_view>

namespace hgros::test {

/// A file in tests/config/yaml.
inline std::filesystem::path FixtureFile(std::string_view name) {
  return std::filesystem::path(HGROS_CONFIG_FIXTURES) / name;
}

}  // namespace hgros::test
