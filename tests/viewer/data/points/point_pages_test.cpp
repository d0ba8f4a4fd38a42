#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "support/seed.hpp"
#include "viewer/data/points/cell_code.hpp"
#include "viewer/data/points/page_book.hpp"
#include "viewer/data/points/point_boxes.hpp"

namespace hgros::viewer {
namespace {

TEST(PointBoxes, LeaveOutOnePointOfAMessage) {
  std::vector<Eigen::Vector3f> points(100, Eigen::Vector3f(1, 2, 3));
  points[5] = {4, 5, 6};
  points[0] = {20'000, 0, 0};
  const PointBoxes boxes = BoxesAround(points);
  EXPECT_EQ(boxes.most.min(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(boxes.most.max(), Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(boxes.all.max().x(), 20'000);
  points[0] = {900, 0, 0};
  EXPECT_EQ(BoxesAround(points).most.max().x(), 900) << "within a kilometer, everything counts";
  EXPECT_TRUE(BoxesAround(std::vector<Eigen::Vector3f>()).most.isEmpty());
}

TEST(PointBoxes, LeaveOutOutliersAmongManyPoints) {
  std::vector<Eigen::Vector3f> points(10'000, Eigen::Vector3f(1, 2, 3));
  for (std::size_t i = 0; i < points.size(); i += 7) points[i] = {0, 0, static_cast<float>(i) / 100};
  for (std::size_t i = 5; i < points.size(); i += 10) points[i] = {static_cast<float>(2000 + i), 0, 0};
  const PointBoxes boxes = BoxesAround(points);
  EXPECT_EQ(boxes.most.min(), Eigen::Vector3d(0, 0, 0));
  EXPECT_LE(boxes.most.max().x(), 1);
  EXPECT_EQ(boxes.most.max().y(), 2);
  EXPECT_NEAR(boxes.most.max().z(), 99.96, 1e-4) << "this one is not in the sample";
  EXPECT_EQ(BoxesAround(points, 1e6).most.max().x(), 11'995) << "no point is that far";
}

/// The pages that the owner of the memory would hold.
class Memory {
 public:
  void Add(const std::vector<Eigen::Vector3d>& positions) {
    const std::size_t before = book_.pages();
    const Eigen::AlignedBox3d box = BoxesAround(positions).most;
    const PageBook::Added added = book_.Add(positions, box);
    ASSERT_EQ(book_.pages(), before + added.new_pages.size());
    pages_.insert(pages_.end(), added.new_pages.begin(), added.new_pages.end());
    codes_.resize(book_.pages() * PageBook::kPagePoints, cell_code::kNowhere);
    sources_.resize(codes_.size());
    std::size_t total = 0;
    for (const PageBook::Run& run : added.runs) {
      ASSERT_LE(run.slot + run.count, PageBook::kPagePoints);
      for (std::size_t i = 0; i < run.count; ++i) {
        const std::size_t at = run.page * PageBook::kPagePoints + run.slot + i;
        ASSERT_EQ(codes_[at], cell_code::kNowhere) << "written twice";
        codes_[at] = added.codes[run.from + i];
        const Eigen::Vector3d& source = positions[added.order[run.from + i]];
        sources_[at] = {source, box.contains(source) ? 0 : (source - box.center()).norm()};
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
      const PageBook::Page& page = pages_[at / PageBook::kPagePoints];
      const Eigen::Vector3d decoded = page.corner + page.edge_meters * cell_code::Decode(codes_[at]);
      const Eigen::Vector3d error = (decoded - sources_[at].position).cwiseAbs();
      const double outlier = sources_[at].outlier_distance / 1000;
      ASSERT_LE(std::max(error.x(), error.y()), std::max(outlier, tolerance_xy));
      ASSERT_LE(error.z(), std::max(outlier, tolerance_z));
    }
    ASSERT_EQ(found, book_.points());
  }
  [[nodiscard]] const PageBook& book() const { return book_; }
  [[nodiscard]] double BytesPerPoint() const {
    return static_cast<double>(4 * codes_.size()) / static_cast<double>(book_.points());
  }

 private:
  struct Source {
    Eigen::Vector3d position;
    double outlier_distance;  ///< 0: it is none.
  };

  PageBook book_;
  std::vector<PageBook::Page> pages_;
  std::vector<std::uint32_t> codes_;
  std::vector<Source> sources_;
};

TEST(PageBook, StoresEveryPointToWithinOneStep) {
  std::mt19937 random(hgros::test::Seed());
  std::normal_distribution<double> meters(0, 0.3);
  Memory memory;
  for (int message = 0; message < 20; ++message) {
    std::vector<Eigen::Vector3d> positions(1000);
    for (auto& at : positions) at = Eigen::Vector3d(meters(random), meters(random), 0.1 * meters(random));
    memory.Add(positions);
  }
  memory.ExpectAllNear(0.5 / 4096 + 1e-9, 0.5 / 2046 + 1e-9);
}

/// Points of a box.
std::vector<Eigen::Vector3d> Spread(int count, const Eigen::Vector3d& corner, const Eigen::Vector3d& size) {
  std::mt19937 random(hgros::test::Seed());
  std::uniform_real_distribution<double> part(0, 1);
  std::vector<Eigen::Vector3d> positions(static_cast<std::size_t>(count));
  for (auto& at : positions) {
    at = corner + size.cwiseProduct(Eigen::Vector3d(part(random), part(random), part(random)));
  }
  return positions;
}
std::vector<Eigen::Vector3d> Wide(int count, const Eigen::Vector3d& corner) {
  return Spread(count, corner, Eigen::Vector3d::Constant(100));
}

TEST(PageBook, IsExactToOneCentimeterAlsoAMillionMetersAwayAndBesideOnePointThatIsFar) {
  std::vector<Eigen::Vector3d> positions = Wide(1000, {500'000, 5'400'000, 0});
  positions[0].x() += 20'000;
  Memory memory;
  memory.Add(positions);
  positions.resize(2);  // 20 km apart
  memory.Add(positions);
  memory.ExpectAllNear(0.01, 0.01);
}

TEST(PageBook, NeedsFewPagesAlsoIfTheFirstMessageHasOnePoint) {
  Memory memory;
  memory.Add({Eigen::Vector3d(0, 0, 0)});
  for (int message = 0; message < 10; ++message) memory.Add(Spread(30'000, {-50, -50, -2}, {100, 100, 5}));
  EXPECT_LT(memory.BytesPerPoint(), 5);
  memory.ExpectAllNear(0.01, 0.01);
}

TEST(PageBook, NeedsFewPagesForWideMessagesAndManyOutliers) {
  Memory wide;
  wide.Add(Spread(300'000, {0, 0, 0}, {10'000, 10'000, 50}));
  EXPECT_LT(wide.BytesPerPoint(), 40);
  wide.ExpectAllNear(0.04, 0.07);
  Memory outliers;
  for (int message = 0; message < 10; ++message) {
    std::vector<Eigen::Vector3d> positions = Spread(10'000, {-30, -30, -2}, {60, 60, 5});
    const auto far = Spread(2000, {-400'000, -400'000, -400'000}, Eigen::Vector3d::Constant(800'000));
    positions.insert(positions.end(), far.begin(), far.end());
    outliers.Add(positions);
  }
  EXPECT_LT(outliers.BytesPerPoint(), 7);
  outliers.ExpectAllNear(0.005, 0.005);
}

TEST(PageBook, IsExactToOneCentimeterAfterAMessageThatIsFarFromAllOthers) {
  Memory memory;
  memory.Add(Wide(1000, {4e5, 0, 0}));
  for (int message = 0; message < 3; ++message) memory.Add(Wide(1000, {-50, -50, -50}));
  memory.ExpectAllNear(0.01, 0.01);
}

TEST(PageBook, APageHasPointsOfOneKind) {
  PageBook book;
  const std::vector<Eigen::Vector3d> one = {Eigen::Vector3d(0.5, 0.5, 0.5)};
  std::vector<std::size_t> pages;
  for (const std::size_t kind : {0U, 1U, 0U, 1U})
    pages.push_back(book.Add(one, BoxesAround(one).most, kind).runs[0].page);
  EXPECT_EQ(pages, (std::vector<std::size_t>{0, 1, 0, 1}));
}

TEST(PageBook, FillsAPageBeforeItBeginsAnother) {
  Memory memory;
  for (int i = 0; i < 300; ++i) memory.Add({Eigen::Vector3d(0.5, 0.5, 0.5)});
  EXPECT_EQ(memory.book().pages(), 2U);
  EXPECT_EQ(memory.book().cells(), 1U);
}

TEST(PageBook, AddsNothingForNoPoints) {
  PageBook book;
  const PageBook::Added added = book.Add({}, {});
  EXPECT_TRUE(added.runs.empty());
  EXPECT_EQ(book.pages(), 0U);
}

TEST(PageBook, ChoosesCellsThatSuitTheExtent) {
  EXPECT_EQ(PageBook::CellFor(130), 16);
  EXPECT_EQ(PageBook::CellFor(30), 4);
  EXPECT_LE(PageBook::CellFor(0), 1);
  EXPECT_EQ(PageBook::CellFor(1000), 16);
  EXPECT_EQ(PageBook::CellFor(8192), 128);
}

}  // namespace
}  // namespace hgros::viewer
