#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include "support/seed.hpp"
#include "viewer/data/points/cell_code.hpp"
#include "viewer/data/points/packed_points.hpp"
#include "viewer/data/points/page_book.hpp"

namespace hgros::viewer {
namespace {

struct Packed {
  PackedBox box;
  std::vector<PackedPoint> points;
};

Packed PackAll(const PlacedPoints& positions, std::span<const float> values) {
  Packed packed{BoxAround(positions, values), std::vector<PackedPoint>(positions.size())};
  Pack(positions, values, packed.box, packed.points);
  return packed;
}

TEST(PackedPoints, ArePreciseToOneStep) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> meters(-100, 100);
  std::vector<Eigen::Vector3f> points(500);
  std::vector<float> values(500);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = Eigen::Vector3f(meters(random), meters(random), meters(random));
    values[i] = meters(random);
  }
  const RigidTransform far(RigidTransform::Rotation(Eigen::AngleAxisd(1, Eigen::Vector3d(1, 2, 3).normalized())),
                           {1e6, 0, -50});
  const PlacedPoints positions(points, far);
  const auto [box, packed] = PackAll(positions, values);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d placed = far * points[i].cast<double>();
    for (int axis = 0; axis < 3; ++axis) {
      const double at = box.corner[axis] + packed[i][static_cast<std::size_t>(axis)] / 65535.0 * box.size[axis];
      EXPECT_NEAR(at, placed[axis], 350.0 / 65535);
    }
    const float value = box.scalar_lo + static_cast<float>(packed[i][3]) / 65535 * (box.scalar_hi - box.scalar_lo);
    EXPECT_NEAR(value, values[i], 200.0F / 65535);
  }
}

TEST(PackedPoints, AcceptASinglePointAndValuesThatAreNotNumbers) {
  const std::vector<Eigen::Vector3f> one = {Eigen::Vector3f(1, 2, 3)};
  const std::vector<float> nothing = {std::numeric_limits<float>::quiet_NaN()};
  const auto [box, points] = PackAll({one, {}}, nothing);
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(box.corner, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(PackAll({{}, {}}, {}).points.empty());
}

/// The pages that the owner of the memory would hold.
class Memory {
 public:
  explicit Memory(double cell_meters) : book_(cell_meters) {}

  void Add(const std::vector<Eigen::Vector3d>& positions) {
    const std::size_t before = book_.pages();
    const PageBook::Added added = book_.Add(positions);
    ASSERT_EQ(book_.pages(), before + added.new_pages.size());
    corners_.insert(corners_.end(), added.new_pages.begin(), added.new_pages.end());
    codes_.resize(book_.pages() * PageBook::kPagePoints, cell_code::kNowhere);
    sources_.resize(codes_.size());
    std::size_t total = 0;
    for (const PageBook::Run& run : added.runs) {
      ASSERT_LE(run.slot + run.count, PageBook::kPagePoints);
      for (std::size_t i = 0; i < run.count; ++i) {
        const std::size_t at = run.page * PageBook::kPagePoints + run.slot + i;
        ASSERT_EQ(codes_[at], cell_code::kNowhere) << "written twice";
        codes_[at] = added.codes[run.from + i];
        sources_[at] = positions[added.order[run.from + i]];
      }
      total += run.count;
    }
    ASSERT_EQ(total, positions.size());
  }

  void ExpectAllNear(double tolerance_xy, double tolerance_z) const {
    std::size_t found = 0;
    for (std::size_t at = 0; at < codes_.size(); ++at) {
      if (codes_[at] == cell_code::kNowhere) continue;
      ++found;
      const Eigen::Vector3d decoded =
          corners_[at / PageBook::kPagePoints] + book_.cell_meters() * cell_code::Decode(codes_[at]);
      const Eigen::Vector3d error = (decoded - sources_[at]).cwiseAbs();
      ASSERT_LE(std::max(error.x(), error.y()), tolerance_xy);
      ASSERT_LE(error.z(), tolerance_z);
    }
    ASSERT_EQ(found, book_.points());
  }
  [[nodiscard]] const PageBook& book() const { return book_; }

 private:
  PageBook book_;
  std::vector<Eigen::Vector3d> corners_;
  std::vector<std::uint32_t> codes_;
  std::vector<Eigen::Vector3d> sources_;
};

TEST(PageBook, StoresEveryPointToWithinOneStep) {
  std::mt19937 random(test::Seed());
  std::normal_distribution<double> meters(0, 30);
  Memory memory(8);
  for (int message = 0; message < 20; ++message) {
    std::vector<Eigen::Vector3d> positions(1000);
    for (auto& at : positions) at = Eigen::Vector3d(meters(random), meters(random), 0.1 * meters(random));
    memory.Add(positions);
  }
  memory.ExpectAllNear(8.0 / 4096 + 1e-9, 8.0 / 2046 + 1e-9);
}

TEST(PageBook, IsAsExactAMillionMetersAway) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> meters(0, 20);
  Memory memory(4);
  std::vector<Eigen::Vector3d> positions(1000);
  for (auto& at : positions) at = Eigen::Vector3d(500'000 + meters(random), 5'400'000 + meters(random), meters(random));
  memory.Add(positions);
  memory.ExpectAllNear(4.0 / 4096 + 1e-6, 4.0 / 2046 + 1e-6);
}

TEST(PageBook, FillsAPageBeforeItBeginsAnother) {
  Memory memory(1);
  for (int i = 0; i < 300; ++i) memory.Add({Eigen::Vector3d(0.5, 0.5, 0.5)});
  EXPECT_EQ(memory.book().pages(), 2U);
  EXPECT_EQ(memory.book().cells(), 1U);
}

TEST(PageBook, AddsNothingForNoPoints) {
  PageBook book(1);
  const PageBook::Added added = book.Add({});
  EXPECT_TRUE(added.runs.empty());
  EXPECT_EQ(book.pages(), 0U);
}

TEST(PageBook, ChoosesCellsThatSuitTheExtent) {
  EXPECT_EQ(PageBook::CellFor(130), 16);
  EXPECT_EQ(PageBook::CellFor(30), 4);
  EXPECT_LE(PageBook::CellFor(0), 1);
  EXPECT_LE(PageBook::CellFor(1e9), 64);
}

}  // namespace
}  // namespace hgros::viewer
