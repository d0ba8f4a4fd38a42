#include "viewer/panels/layout_target.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <string>

namespace hgros::viewer {
namespace {

TEST(LayoutTarget, ReplacesItsOwnFileUntilAnotherProgramChangesIt) {
  const auto folder = std::filesystem::temp_directory_path() / ("layout_target_test_" + std::to_string(getpid()));
  std::filesystem::create_directory(folder);
  const std::filesystem::path file = folder / "layout.yaml";
  const std::filesystem::path second = folder / "layout-2.yaml";
  LayoutTarget target(file);
  EXPECT_EQ(target.Next(), file) << "there is none";
  std::ofstream(file) << "of another one";
  EXPECT_EQ(target.Next(), second);
  target.NoteOwn();
  EXPECT_EQ(target.Next(), file);
  std::ofstream(file) << "edited";
  EXPECT_EQ(target.Next(), second);
  std::filesystem::remove(file);
  EXPECT_EQ(target.Next(), file);
  std::filesystem::create_directory(file);
  EXPECT_EQ(target.Next(), second);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace hgros::viewer
