#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/config/config.hpp"
#include "support/path.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::test {

/// A file in tests/config/yaml.
inline std::filesystem::path FixtureFile(std::string_view name) {
  return std::filesystem::path(Path("fixtures")) / name;
}

/// Expects that `load` throws a ConfigError at `where` whose text has all `parts`.
template <typename Load>
void ExpectConfigError(Load load, const std::string& where, const std::vector<std::string>& parts) {
  try {
    (void)load();
    ADD_FAILURE() << "nothing was thrown; expected an error at " << where;
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.where(), where) << error.what();
    for (const std::string& part : parts) {
      EXPECT_NE(std::string_view(error.what()).find(part), std::string_view::npos)
          << error.what() << "\nlacks: " << part;
    }
  }
}

/// The same for a text. `at` is "line:column", or empty for no position.
inline void ExpectFault(std::string_view yaml, const std::string& at, const std::vector<std::string>& parts) {
  ExpectConfigError([&] { return Config::Parse(yaml, "robot.yaml"); }, at.empty() ? "robot.yaml" : "robot.yaml:" + at,
                    parts);
}

}  // namespace hgros::test
