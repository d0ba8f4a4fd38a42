#include "viewer/data/mesh_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

namespace hgros::viewer {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class MeshFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "meshes-XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path Write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  fs::path folder_;
  std::vector<TriangleCorner> corners_;
};

TEST_F(MeshFile, GivesTheTrianglesOfAnStlWhateverTheCaseOfItsEnding) {
  const fs::path path = Write("one.STL", "solid x\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2 0\nendsolid");
  ASSERT_EQ(ReadMesh(path, corners_), "");
  ASSERT_EQ(corners_.size(), 3U);
  EXPECT_EQ(corners_[2].position, Eigen::Vector3d(0, 2, 0));
  EXPECT_EQ(AlphaOf(corners_[2].color), 0U);
}

TEST_F(MeshFile, ThatCannotBeReadIsASentence) {
  EXPECT_THAT(ReadMesh(folder_ / "none.stl", corners_), HasSubstr("cannot be read"));
  EXPECT_THAT(ReadMesh(Write("one.txt", ""), corners_), HasSubstr("\".txt\""));
  EXPECT_THAT(ReadMesh(Write("bad.stl", "solid x\nvertex 0 0 zero\n"), corners_), HasSubstr("bad.stl"));
  EXPECT_TRUE(corners_.empty());
}

}  // namespace
}  // namespace hgros::viewer
