#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "hgros/params/param_server.hpp"
#include "support/error_of.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::test {

/// Gives each test its own folder.
class ParamsTest : public testing::Test {
 protected:
  std::filesystem::path Write(std::string_view name, std::string_view text) const { return folder_.Write(name, text); }
  [[nodiscard]] std::string Read(const std::filesystem::path& file) const { return folder_.Read(file.c_str()); }

  const ScratchFolder folder_;
};

}  // namespace hgros::test
