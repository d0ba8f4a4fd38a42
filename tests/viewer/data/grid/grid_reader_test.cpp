#include "viewer/data/grid/grid_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "hgros/codec/packed_elements.hpp"
#include "viewer/data/grid/voxel_reader.hpp"
#include "viewer/e2e/message_parts.hpp"

namespace hgros::viewer {
namespace {

using foxglove::Grid;
using foxglove::PackedElementField;
using foxglove::VoxelGrid;
using test::AddField;
using test::SetCells;
using ::testing::HasSubstr;

template <class T>
Grid GridOf(const std::vector<T>& values, unsigned columns, PackedElementField::NumericType type) {
  Grid grid;
  SetCells(grid, columns, sizeof(T), 0.5);
  grid.mutable_cell_size()->set_y(0.25);
  AddField(grid, "value", type);
  grid.set_data(values.data(), values.size() * sizeof(T));
  return grid;
}

std::string Read(const Grid& grid, GridPicture& picture, std::string_view field = {},
                 std::optional<GridPalette> palette = std::nullopt) {
  return ReadGrid(Bulk<Grid>(grid), field, palette, picture);
}

TEST(GridReader, ColorsOccupancyAsAMap) {
  GridPicture picture;
  ASSERT_EQ(Read(GridOf<std::int8_t>({0, 100, -1, 50}, 2, PackedElementField::INT8), picture), "");
  EXPECT_EQ(picture.columns, 2U);
  EXPECT_EQ(picture.rows, 2U);
  EXPECT_EQ(picture.cell_size, Eigen::Vector2d(0.5, 0.25));
  ASSERT_EQ(picture.pixels.size(), 4U);
  EXPECT_EQ(picture.pixels[0], MakeRgba(255, 255, 255));
  EXPECT_EQ(picture.pixels[1], MakeRgba(0, 0, 0));
  EXPECT_EQ(picture.pixels[2], ColorOfCell(GridPalette::kMap, -1));
  EXPECT_EQ(picture.pixels[3], MakeRgba(128, 128, 128));
  GridPicture unsigned_bytes;
  ASSERT_EQ(Read(GridOf<std::uint8_t>({0, 100, 255, 50}, 2, PackedElementField::UINT8), unsigned_bytes), "");
  EXPECT_EQ(unsigned_bytes.pixels, picture.pixels);
}

TEST(GridReader, ColorsCostsFromBlueToRed) {
  EXPECT_EQ(AlphaOf(ColorOfCell(GridPalette::kCostmap, 0)), 0U);
  EXPECT_EQ(ColorOfCell(GridPalette::kCostmap, 99), MakeRgba(0, 255, 255));
  EXPECT_EQ(ColorOfCell(GridPalette::kCostmap, 100), MakeRgba(255, 0, 255));
  EXPECT_EQ(ColorOfCell(GridPalette::kCostmap, 98), MakeRgba(250, 0, 5));
  EXPECT_EQ(ColorOfCell(GridPalette::kCostmap, -1), ColorOfCell(GridPalette::kMap, -1));
}

template <class T>
class GridReaderOf : public testing::Test {};
using Types =
    testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t, float, double>;
TYPED_TEST_SUITE(GridReaderOf, Types);

TYPED_TEST(GridReaderOf, ReadsEveryNumericType) {
  constexpr auto kType = static_cast<PackedElementField::NumericType>(NumericTypeOf<TypeParam>());
  GridPicture picture;
  ASSERT_EQ(Read(GridOf<TypeParam>({10, 20, 30, 30}, 4, kType), picture, "value", GridPalette::kRaw), "");
  EXPECT_EQ(picture.pixels, (std::vector<Rgba>{MakeRgba(0, 0, 0), MakeRgba(128, 128, 128), MakeRgba(255, 255, 255),
                                               MakeRgba(255, 255, 255)}));
}

TEST(GridReader, MakesCellsThatAreNotNumbersTransparent) {
  GridPicture picture;
  ASSERT_EQ(Read(GridOf<float>({1, NAN, 3, INFINITY}, 4, PackedElementField::FLOAT32), picture), "");
  EXPECT_EQ(AlphaOf(picture.pixels[1]), 0U);
  EXPECT_EQ(AlphaOf(picture.pixels[3]), 0U);
  EXPECT_EQ(picture.pixels[2], MakeRgba(255, 255, 255));
}

TEST(GridReader, ReadsCellsWithColorsAndPadding) {
  Grid grid;
  SetCells(grid, 1, 4, 1);
  grid.set_row_stride(6);
  unsigned offset = 0;
  for (const char* name : {"blue", "green", "red"}) AddField(grid, name, PackedElementField::UINT8, offset++);
  grid.set_data(std::string("\x01\x02\x03.xx\x04\x05\x06.", 10));
  GridPicture picture;
  ASSERT_EQ(Read(grid, picture), "");
  EXPECT_TRUE(picture.colored);
  EXPECT_EQ(picture.rows, 2U) << "the last row has no padding";
  EXPECT_EQ(picture.pixels, (std::vector<Rgba>{MakeRgba(3, 2, 1), MakeRgba(6, 5, 4)}));
}

TEST(GridReader, ReportsInvalidGrids) {
  const auto fault = [](const auto& change) {
    Grid grid = GridOf<std::int8_t>({0, 1, 2, 3}, 2, PackedElementField::INT8);
    change(grid);
    GridPicture picture;
    picture.field = "before";
    std::string said = Read(grid, picture);
    EXPECT_EQ(picture.field, "before");
    return said;
  };
  EXPECT_THAT(fault([](Grid& grid) { grid.clear_fields(); }), HasSubstr("no field"));
  EXPECT_THAT(fault([](Grid& grid) { grid.set_row_stride(0); }), HasSubstr("rows have no bytes"));
  EXPECT_THAT(fault([](Grid& grid) { grid.set_cell_stride(0); }), HasSubstr("does not fit into its cell"));
  EXPECT_THAT(fault([](Grid& grid) { grid.mutable_fields(0)->set_offset(4'000'000'000); }),
              HasSubstr("does not fit into its cell"));
  EXPECT_THAT(fault([](Grid& grid) { grid.set_column_count(4'000'000'000); }), HasSubstr("cells"));
  EXPECT_THAT(fault([](Grid& grid) { grid.set_column_count(3); }), HasSubstr("do not fit"));
  EXPECT_THAT(fault([](Grid& grid) { grid.mutable_fields(0)->set_type(PackedElementField::UNKNOWN); }),
              HasSubstr("unknown"));
  EXPECT_THAT(fault([](Grid& grid) { grid.mutable_cell_size()->set_x(0); }), HasSubstr("no size"));
  GridPicture picture;
  EXPECT_THAT(Read(GridOf<std::int8_t>({0}, 1, PackedElementField::INT8), picture, "height"),
              HasSubstr("no field \"height\""));
}

VoxelGrid Voxels(unsigned columns, unsigned rows, const std::vector<std::uint8_t>& values) {
  VoxelGrid grid;
  test::SetVoxels(grid, columns, rows, 1, 0.1);
  AddField(grid, "occupancy", PackedElementField::UINT8);
  grid.set_data(values.data(), values.size());
  return grid;
}

TEST(VoxelReader, DrawsOnlyVisibleFaces) {
  VoxelPicture picture;
  ASSERT_EQ(ReadVoxels(Bulk<VoxelGrid>(Voxels(3, 3, std::vector<std::uint8_t>(27, 1))), {}, 0, picture), "");
  EXPECT_EQ(picture.occupied, 27U);
  EXPECT_EQ(picture.cubes.size(), 26U) << "the voxel in the middle is hidden";
  std::size_t faces = 0;
  for (const VoxelCube& cube : picture.cubes) faces += static_cast<std::size_t>(std::popcount(cube.faces));
  EXPECT_EQ(faces, 6U * 9U);
}

TEST(VoxelReader, TreatsVoxelsUpToTheThresholdAsEmpty) {
  VoxelPicture picture;
  ASSERT_EQ(ReadVoxels(Bulk<VoxelGrid>(Voxels(2, 2, {0, 5, 9, 10, 0, 0, 0, 20})), {}, 9, picture), "");
  ASSERT_EQ(picture.cubes.size(), 2U);
  EXPECT_EQ(picture.cubes[0].cell, (std::array<std::uint32_t, 3>{1, 1, 0}));
  EXPECT_EQ(picture.cubes[0].value, 10);
  EXPECT_EQ(picture.cubes[0].faces, 0b011111) << "another voxel is above it";
  EXPECT_EQ(picture.cubes[1].faces, 0b101111);
}

TEST(VoxelReader, ReportsInvalidVoxelGrids) {
  const auto fault = [](const auto& change) {
    VoxelGrid grid = Voxels(2, 2, std::vector<std::uint8_t>(8));
    change(grid);
    VoxelPicture picture;
    return ReadVoxels(Bulk<VoxelGrid>(grid), {}, 0, picture);
  };
  EXPECT_EQ(fault([](VoxelGrid&) {}), "");
  EXPECT_THAT(fault([](VoxelGrid& grid) { grid.set_slice_stride(0); }), HasSubstr("slices have no bytes"));
  EXPECT_THAT(fault([](VoxelGrid& grid) { grid.set_row_count(4'000'000'000); }), HasSubstr("more than"));
  EXPECT_THAT(fault([](VoxelGrid& grid) { grid.set_row_stride(5); }), HasSubstr("do not fit"));
  EXPECT_THAT(fault([](VoxelGrid& grid) { grid.clear_cell_size(); }), HasSubstr("no size"));
  EXPECT_THAT(fault([](VoxelGrid& grid) { grid.clear_fields(); }), HasSubstr("no field"));
}

}  // namespace
}  // namespace hgros::viewer
