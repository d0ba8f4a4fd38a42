#include "viewer/panels/layout_target.hpp"

#include <gtest/gtest.h>

#include "support/scratch_folder.hpp"

namespace hgros::viewer {
namespace {

TEST(LayoutTarget, ReplacesItsOwnFileUntilAnotherProgramChangesIt) {
  const hgros::test::ScratchFolder folder;
  const std::filesystem::path file = folder / "layout.yaml";
  const std::filesystem::path second = folder / "layout-2.yaml";
  LayoutTarget target(file);
  EXPECT_EQ(target.Next(), file) << "there is none";
  folder.Write("layout.yaml", "of another one");
  EXPECT_EQ(target.Next(), second);
  target.NoteOwn();
  EXPECT_EQ(target.Next(), file);
  folder.Write("layout.yaml", "edited");
  EXPECT_EQ(target.Next(), second);
  std::filesystem::remove(file);
  EXPECT_EQ(target.Next(), file);
  std::filesystem::create_directory(file);
  EXPECT_EQ(target.Next(), second);
}

}  // namespace
}  // namespace hgros::viewer
