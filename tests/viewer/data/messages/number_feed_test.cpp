#include "viewer/data/messages/number_feed.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "foxglove/LaserScan.pb.h"
#include "foxglove/PoseInFrame.pb.h"
#include "hgros/codec/message.hpp"

namespace hgros::viewer {
namespace {

/// Bytes as they arrive from another process.
RawMessage RawOf(std::string bytes, const std::shared_ptr<const MessageSchema>& schema) {
  const auto kept = std::make_shared<const std::string>(std::move(bytes));
  return {schema, {AsBytes(*kept), kept}};
}
template <class T>
std::shared_ptr<const MessageSchema> SchemaFor() {
  return std::make_shared<const MessageSchema>(SchemaOf(TypeOf<T>()));
}

constexpr Time kLate{1'000'000'000};

class NumberFeedTest : public ::testing::Test {
 protected:
  void AddPoseAt(double x, Time at) {
    foxglove::PoseInFrame pose;
    pose.mutable_pose()->mutable_position()->set_x(x);
    feed_.Add(RawOf(pose.SerializeAsString(), schema_), at);
  }

  NumberFeed feed_{std::chrono::seconds(10)};
  const std::shared_ptr<const MessageSchema> schema_ = SchemaFor<foxglove::PoseInFrame>();
};

TEST_F(NumberFeedTest, KeepsWatchedNumbersOverTime) {
  feed_.Watch("pose.position.x");
  AddPoseAt(1, {100});
  AddPoseAt(3, {200});
  const auto view = feed_.Look("pose.position.x", {0}, {300}, 3);
  ASSERT_EQ(view.columns.size(), 2U);
  EXPECT_EQ(view.columns[1].last, 3);
  EXPECT_EQ(view.newest, 3);
  EXPECT_EQ(view.fault, "");
  EXPECT_EQ(feed_.Newest("pose.position.x"), Time{200});
  EXPECT_FALSE(feed_.Newest("pose.position.y")) << "the path is not watched";
}

TEST_F(NumberFeedTest, ExplainsMissingNumbers) {
  feed_.Watch("pose.position.q");
  EXPECT_EQ(feed_.Look("pose.position.q", {0}, kLate, 1).fault, "") << "no message has arrived";
  AddPoseAt(1, {100});
  EXPECT_NE(feed_.Look("pose.position.q", {0}, kLate, 1).fault.find("no field \"q\""), std::string::npos);
}

TEST_F(NumberFeedTest, ListsPathsThatCanBeWatched) {
  EXPECT_TRUE(feed_.Paths().empty());
  AddPoseAt(1, {100});
  const auto paths = feed_.Paths();
  EXPECT_NE(std::ranges::find(paths, "pose.position.x"), paths.end());
}

TEST_F(NumberFeedTest, SurvivesInvalidMessages) {
  feed_.Watch("pose.position.x");
  feed_.Add(RawOf("\xff\xff\xff\xff", schema_), {100});
  EXPECT_NE(feed_.fault().find("not a foxglove.PoseInFrame"), std::string::npos) << feed_.fault();
  AddPoseAt(2, {200});
  EXPECT_EQ(feed_.fault(), "");
  EXPECT_EQ(feed_.Look("pose.position.x", {0}, kLate, 1).newest, 2);
}

TEST_F(NumberFeedTest, ReadsTheNewTypeWhenThePublisherChangesIt) {
  feed_.Watch("pose.position.x");
  feed_.Watch("start_angle");
  AddPoseAt(1, {100});
  foxglove::LaserScan scan;
  scan.set_start_angle(0.5);
  feed_.Add(RawOf(scan.SerializeAsString(), SchemaFor<foxglove::LaserScan>()), {200});
  EXPECT_EQ(feed_.Look("start_angle", {0}, kLate, 1).newest, 0.5);
  EXPECT_EQ(feed_.Look("pose.position.x", {0}, kLate, 1).newest, 1) << "earlier values stay";
}

TEST_F(NumberFeedTest, ForgetsPathsThatAreNoLongerWatched) {
  feed_.Watch("pose.position.x");
  feed_.Watch("pose.position.y");
  AddPoseAt(1, {100});
  feed_.Forget("pose.position.x");
  EXPECT_FALSE(feed_.Newest("pose.position.x"));
  EXPECT_TRUE(feed_.Newest("pose.position.y"));
  feed_.Clear();
  EXPECT_FALSE(feed_.Newest("pose.position.y"));
}

TEST_F(NumberFeedTest, CanBeReadWhileMessagesArrive) {
  feed_.Watch("pose.position.x");
  {
    const std::jthread sender([&](const std::stop_token& stop) {
      for (std::int64_t i = 1; !stop.stop_requested(); ++i) AddPoseAt(1, {i});
    });
    for (int i = 0; i < 200; ++i) {
      feed_.Watch("pose.position.y");
      (void)feed_.Look("pose.position.x", {0}, kLate, 100);
      feed_.Forget("pose.position.y");
    }
  }
  AddPoseAt(4, kLate);
  EXPECT_EQ(feed_.Look("pose.position.x", {0}, {kLate.nanoseconds + 1}, 1).newest, 4);
}

}  // namespace
}  // namespace hgros::viewer
