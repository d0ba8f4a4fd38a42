#include "viewer/data/whole_file.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

namespace hgros::viewer {
namespace {

namespace fs = std::filesystem;

TEST(WholeFile, ReadsAllBytesOfARegularFile) {
  std::string name = (fs::temp_directory_path() / "whole-XXXXXX").string();
  const fs::path folder = mkdtemp(name.data());
  const std::string bytes("a\0b\r\n", 5);
  std::ofstream(folder / "file", std::ios::binary) << bytes;
  std::ofstream(folder / "empty");  // NOLINT(bugprone-unused-raii): it is made
  EXPECT_EQ(ReadWholeFile(folder / "file"), bytes);
  EXPECT_EQ(ReadWholeFile(folder / "empty"), "");
  EXPECT_FALSE(ReadWholeFile(folder / "nothing"));
  EXPECT_FALSE(ReadWholeFile(folder)) << "a folder";
  EXPECT_FALSE(ReadWholeFile("/dev/zero"));
  fs::remove_all(folder);
}

}  // namespace
}  // namespace hgros::viewer
