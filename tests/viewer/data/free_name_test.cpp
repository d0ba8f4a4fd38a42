#include "viewer/data/free_name.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <string>

namespace hgros::viewer {
namespace {

TEST(FreeName, IsTheFirstThatIsNotTaken) {
  const auto folder = std::filesystem::temp_directory_path() / ("free_name_test_" + std::to_string(getpid()));
  std::filesystem::create_directory(folder);
  EXPECT_EQ(FreeName(folder / "layout.yaml"), folder / "layout.yaml");
  std::ofstream(folder / "layout.yaml") << "mine";
  EXPECT_EQ(FreeName(folder / "layout.yaml"), folder / "layout-2.yaml");
  std::filesystem::create_symlink("nowhere", folder / "layout-2.yaml");
  EXPECT_EQ(FreeName(folder / "layout.yaml"), folder / "layout-3.yaml") << "a link is taken, too";
  std::ofstream(folder / "plain") << "mine";
  EXPECT_EQ(FreeName(folder / "plain"), folder / "plain-2");
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace hgros::viewer
