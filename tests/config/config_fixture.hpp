#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/config/config.hpp"

namespace hgros::test {

/// A folder that lives as long as the test.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "hgros_config_XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~ScratchFolder() { std::filesystem::remove_all(path_); }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::filesystem::path Write(std::string_view name, std::string_view text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

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
