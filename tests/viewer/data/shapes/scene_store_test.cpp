#include "viewer/data/shapes/scene_store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "support/seed.hpp"
#include "viewer/e2e/message_parts.hpp"

namespace hgros::viewer {
namespace {

using foxglove::SceneEntityDeletion;
using foxglove::SceneUpdate;
using ::testing::HasSubstr;

constexpr std::int64_t kSecond = 1'000'000'000;

foxglove::SceneEntity& Add(SceneUpdate& update, const std::string& id, std::int64_t seconds, double x = 0) {
  auto& entity = test::AddEntity(update, id);
  entity.mutable_timestamp()->set_seconds(seconds);
  entity.add_cubes()->mutable_pose()->mutable_position()->set_x(x);
  return entity;
}

void Delete(SceneUpdate& update, SceneEntityDeletion::Type type, const std::string& id, std::int64_t seconds) {
  auto& deletion = *update.add_deletions();
  deletion.set_type(type);
  deletion.set_id(id);
  deletion.mutable_timestamp()->set_seconds(seconds);
}

std::vector<std::string> Ids(const SceneStore& store) {
  std::vector<std::string> ids;
  for (const auto& [id, entity] : store.entities()) ids.push_back(id);
  return ids;
}

SceneStore::FramePose Everywhere() {
  return [](const std::string&, std::optional<Time>) { return Eigen::Isometry3d::Identity(); };
}

class SceneStoreTest : public ::testing::Test {
 protected:
  SceneStore store_;
  SceneUpdate update_;
};

TEST_F(SceneStoreTest, ReplacesAWholeEntityById) {
  SceneUpdate first, second;
  Add(first, "a", 1).add_spheres();
  Add(second, "a", 2, 7);
  EXPECT_EQ(store_.Apply(first), "");
  EXPECT_EQ(store_.Apply(second), "");
  const auto drawing = store_.Draw(Everywhere(), Eigen::Vector3d::Zero());
  EXPECT_TRUE(drawing.shapes.spheres.empty());
  ASSERT_EQ(drawing.shapes.cubes.size(), 1U);
  EXPECT_EQ(drawing.shapes.cubes[0].pose(0, 3), 7);
}

TEST_F(SceneStoreTest, DeletesOnlyOlderEntities) {
  for (const char* id : {"a", "b", "c"}) Add(update_, id, 10);
  Add(update_, "late", 20);
  EXPECT_EQ(store_.Apply(update_), "");
  SceneUpdate one;
  Delete(one, SceneEntityDeletion::MATCHING_ID, "a", 11);
  Delete(one, SceneEntityDeletion::MATCHING_ID, "b", 10);
  Delete(one, SceneEntityDeletion::MATCHING_ID, "nobody", 11);
  EXPECT_EQ(store_.Apply(one), "");
  EXPECT_EQ(Ids(store_), (std::vector<std::string>{"b", "c", "late"})) << "b is not older than the deletion";
  SceneUpdate all;
  Delete(all, SceneEntityDeletion::ALL, "", 15);
  Add(all, "new", 15);
  EXPECT_EQ(store_.Apply(all), "");
  EXPECT_EQ(Ids(store_), (std::vector<std::string>{"late", "new"})) << "deletions come before entities";
  SceneUpdate whenever;
  Delete(whenever, SceneEntityDeletion::ALL, "", 0);
  EXPECT_EQ(store_.Apply(whenever), "");
  EXPECT_TRUE(store_.entities().empty());
}

TEST_F(SceneStoreTest, RemovesEntitiesAfterTheirLifetime) {
  Add(update_, "short", 10).mutable_lifetime()->set_seconds(1);
  Add(update_, "long", 10).mutable_lifetime()->set_seconds(5);
  Add(update_, "ever", 10);
  EXPECT_EQ(store_.Apply(update_), "");
  EXPECT_EQ(store_.NextEnd().value().nanoseconds, 11 * kSecond);
  EXPECT_FALSE(store_.Expire({11 * kSecond - 1}));
  EXPECT_TRUE(store_.Expire({11 * kSecond}));
  EXPECT_EQ(Ids(store_), (std::vector<std::string>{"ever", "long"}));
  EXPECT_TRUE(store_.Expire({100 * kSecond}));
  EXPECT_FALSE(store_.NextEnd());
}

TEST_F(SceneStoreTest, StartsTheLifetimeOfAnUnstampedEntityAtItsArrival) {
  Add(update_, "unstamped", 0).mutable_lifetime()->set_seconds(1);
  Add(update_, "nearly for ever", 10).mutable_lifetime()->set_seconds(std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(store_.Apply(update_, Time{50 * kSecond}), "");
  EXPECT_EQ(store_.NextEnd().value().nanoseconds, 51 * kSecond);
  EXPECT_TRUE(store_.Expire({51 * kSecond}));
  EXPECT_EQ(Ids(store_), (std::vector<std::string>{"nearly for ever"}));
}

TEST_F(SceneStoreTest, MovesOnlyLockedEntitiesWithTheirFrame) {
  Add(update_, "locked", 10).set_frame_locked(true);
  Add(update_, "still", 10);
  EXPECT_EQ(store_.Apply(update_), "");
  // The frame is at x = 10 at that time, and at x = 99 now.
  const auto drawing = store_.Draw(
      [](const std::string&, std::optional<Time> at) -> std::optional<Eigen::Isometry3d> {
        return Eigen::Isometry3d(
            Eigen::Translation3d(at ? static_cast<double>(at->nanoseconds) / kSecond : 99.0, 0, 0));
      },
      Eigen::Vector3d::Zero());
  ASSERT_EQ(drawing.shapes.cubes.size(), 2U);
  EXPECT_EQ(drawing.shapes.cubes[0].pose(0, 3), 99);
  EXPECT_EQ(drawing.shapes.cubes[1].pose(0, 3), 10);
}

TEST_F(SceneStoreTest, ReportsAnUnknownFrame) {
  Add(update_, "a", 1).set_frame_id("moon");
  Add(update_, "b", 1);
  EXPECT_EQ(store_.Apply(update_), "");
  const auto drawing = store_.Draw(
      [](const std::string& frame, std::optional<Time>) -> std::optional<Eigen::Isometry3d> {
        if (frame == "moon") return std::nullopt;
        return Eigen::Isometry3d::Identity();
      },
      Eigen::Vector3d::Zero());
  EXPECT_EQ(drawing.shapes.cubes.size(), 1U);
  EXPECT_EQ(drawing.unplaced, 1U);
  EXPECT_EQ(drawing.unplaced_frame, "moon");
}

TEST_F(SceneStoreTest, KeepsHugeCoordinatesExactRelativeToTheOrigin) {
  Add(update_, "a", 1, 1e7 + 0.001);
  EXPECT_EQ(store_.Apply(update_), "");
  const auto drawing = store_.Draw(Everywhere(), {1e7, 0, 0});
  EXPECT_NEAR(static_cast<float>(drawing.shapes.cubes.at(0).pose(0, 3)), 0.001F, 1e-6);
}

TEST_F(SceneStoreTest, ReportsAnEntityThatIsShownIncompletely) {
  Add(update_, "bad", 1).add_models();
  EXPECT_THAT(store_.Apply(update_), HasSubstr("Entity \"bad\": Model 0 names no file"));
  EXPECT_EQ(store_.entities().size(), 1U);
}

TEST_F(SceneStoreTest, ReportsShapesTooFarAwayAndShowsTheRest) {
  Add(update_, "near", 1);
  Add(update_, "far", 1, 9e307);
  EXPECT_THAT(store_.Apply(update_), HasSubstr("Entity \"far\": 1 of its shapes"));
  EXPECT_EQ(store_.Draw(Everywhere(), Eigen::Vector3d::Zero()).shapes.cubes.size(), 1U);
  hgros::Shapes shapes;
  auto& far = *shapes.add_shapes();
  far.set_name("far");
  far.mutable_pose()->mutable_position()->set_x(-9e307);
  far.mutable_point();
  EXPECT_THAT(store_.Apply(shapes), HasSubstr("Shape \"far\": 1 of its shapes"));
}

TEST_F(SceneStoreTest, LimitsTheTotalNumberOfShapes) {
  constexpr int kMost = 1000;
  const auto lines = [](const std::string& id, int count) {
    SceneUpdate update;
    auto& line = *test::AddEntity(update, id).add_lines();
    line.add_points();
    line.mutable_indices()->Resize(count + 1, 0);
    return update;
  };
  SceneStore store(kMost);
  EXPECT_EQ(store.Apply(lines("a", kMost - 10)), "");
  EXPECT_THAT(store.Apply(lines("b", 11)), HasSubstr("Entity \"b\": With it there are more than 1000 shapes"));
  EXPECT_EQ(store.Apply(lines("b", 10)), "") << "left-out entities take no space";
  EXPECT_EQ(store.Apply(lines("a", kMost - 10)), "") << "replaced entities take no space";
  SceneUpdate gone;
  Delete(gone, SceneEntityDeletion::MATCHING_ID, "a", 0);
  EXPECT_EQ(store.Apply(gone), "");
  EXPECT_EQ(store.Apply(lines("c", kMost - 10)), "") << "deleted entities take no space";
  hgros::Shapes all;
  all.set_remove_all(true);
  EXPECT_EQ(store.Apply(all), "");
  EXPECT_EQ(store.Apply(lines("a", kMost)), "");
}

// Compared with a naive model: a list of all updates, read from the end.
TEST_F(SceneStoreTest, MatchesANaiveModel) {
  std::mt19937 random(hgros::test::Seed());
  std::map<std::string, std::int64_t> model;
  for (int i = 0; i < 2000; ++i) {
    SceneUpdate update;
    const std::string id(1, static_cast<char>('a' + random() % 6));
    const auto seconds = static_cast<std::int64_t>(1 + random() % 20);
    switch (random() % 4) {
      case 0:
        Delete(update, SceneEntityDeletion::MATCHING_ID, id, seconds);
        if (model.contains(id) && model[id] < seconds) model.erase(id);
        break;
      case 1:
        Delete(update, SceneEntityDeletion::ALL, "", seconds);
        std::erase_if(model, [&](const auto& entry) { return entry.second < seconds; });
        break;
      default: Add(update, id, seconds); model[id] = seconds;
    }
    ASSERT_EQ(store_.Apply(update), "");
    ASSERT_EQ(store_.entities().size(), model.size());
    for (const auto& [name, at] : model) ASSERT_EQ(store_.entities().at(name).stamp.nanoseconds, at * kSecond);
  }
}

}  // namespace
}  // namespace hgros::viewer
