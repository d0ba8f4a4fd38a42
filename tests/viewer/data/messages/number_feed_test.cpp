#include "viewer/data/messages/number_feed.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "foxglove/LaserScan.pb.h"
#include "foxglove/PoseInFrame.pb.h"
#include "hgros/codec/message.hpp"

namespace hgros::viewer {
namespace {

/// A message as it arrives from another process.
template <class T>
RawMessage RawOf(const T& message, const std::shared_ptr<const MessageSchema>& schema) {
  auto bytes = std::make_shared<const std::string>(message.SerializeAsString());
  const Bytes view(reinterpret_cast<const std::byte*>(bytes->data()), bytes->size());  // NOLINT: bytes are bytes
  return {schema, {view, std::move(bytes)}};
}
template <class T>
std::shared_ptr<const MessageSchema> SchemaFor() {
  return std::make_shared<const MessageSchema>(SchemaOf(TypeOf<T>()));
}

foxglove::PoseInFrame PoseAt(double x) {
  foxglove::PoseInFrame pose;
  pose.mutable_pose()->mutable_position()->set_x(x);
  return pose;
}

constexpr Time kLate{1'000'000'000};

TEST(NumberFeed, KeepsWatchedNumbersOverTime) {
  NumberFeed feed(std::chrono::seconds(10));
  const auto schema = SchemaFor<foxglove::PoseInFrame>();
  feed.Watch("pose.position.x");
  feed.Add(RawOf(PoseAt(1), schema), {100});
  feed.Add(RawOf(PoseAt(3), schema), {200});
  const auto view = feed.Look("pose.position.x", {0}, {300}, 3);
  ASSERT_EQ(view.columns.size(), 2U);
  EXPECT_EQ(view.columns[1].last, 3);
  EXPECT_EQ(view.newest, 3);
  EXPECT_EQ(view.fault, "");
  EXPECT_EQ(feed.Newest("pose.position.x"), Time{200});
  EXPECT_FALSE(feed.Newest("pose.position.y")) << "the path is not watched";
}

TEST(NumberFeed, ExplainsMissingNumbers) {
  NumberFeed feed(std::chrono::seconds(10));
  feed.Watch("pose.position.q");
  EXPECT_EQ(feed.Look("pose.position.q", {0}, kLate, 1).fault, "") << "no message has arrived";
  feed.Add(RawOf(PoseAt(1), SchemaFor<foxglove::PoseInFrame>()), {100});
  EXPECT_NE(feed.Look("pose.position.q", {0}, kLate, 1).fault.find("no field \"q\""), std::string::npos);
}

TEST(NumberFeed, ListsPathsThatCanBeWatched) {
  NumberFeed feed(std::chrono::seconds(10));
  EXPECT_TRUE(feed.Paths().empty());
  feed.Add(RawOf(PoseAt(1), SchemaFor<foxglove::PoseInFrame>()), {100});
  const auto paths = feed.Paths();
  EXPECT_NE(std::ranges::find(paths, "pose.position.x"), paths.end());
}

TEST(NumberFeed, SurvivesInvalidMessages) {
  NumberFeed feed(std::chrono::seconds(10));
  const auto schema = SchemaFor<foxglove::PoseInFrame>();
  feed.Watch("pose.position.x");
  auto bytes = std::make_shared<const std::string>("\xff\xff\xff\xff");
  const Bytes view(reinterpret_cast<const std::byte*>(bytes->data()), bytes->size());  // NOLINT: bytes are bytes
  feed.Add({schema, {view, bytes}}, {100});
  EXPECT_NE(feed.fault().find("not a foxglove.PoseInFrame"), std::string::npos) << feed.fault();
  feed.Add(RawOf(PoseAt(2), schema), {200});
  EXPECT_EQ(feed.fault(), "");
  EXPECT_EQ(feed.Look("pose.position.x", {0}, kLate, 1).newest, 2);
}

TEST(NumberFeed, ReadsTheNewTypeWhenThePublisherChangesIt) {
  NumberFeed feed(std::chrono::seconds(10));
  feed.Watch("pose.position.x");
  feed.Watch("start_angle");
  feed.Add(RawOf(PoseAt(1), SchemaFor<foxglove::PoseInFrame>()), {100});
  foxglove::LaserScan scan;
  scan.set_start_angle(0.5);
  feed.Add(RawOf(scan, SchemaFor<foxglove::LaserScan>()), {200});
  EXPECT_EQ(feed.Look("start_angle", {0}, kLate, 1).newest, 0.5);
  EXPECT_EQ(feed.Look("pose.position.x", {0}, kLate, 1).newest, 1) << "earlier values stay";
}

TEST(NumberFeed, ForgetsPathsThatAreNoLongerWatched) {
  NumberFeed feed(std::chrono::seconds(10));
  feed.Watch("pose.position.x");
  feed.Watch("pose.position.y");
  feed.Add(RawOf(PoseAt(1), SchemaFor<foxglove::PoseInFrame>()), {100});
  feed.Forget("pose.position.x");
  EXPECT_FALSE(feed.Newest("pose.position.x"));
  EXPECT_TRUE(feed.Newest("pose.position.y"));
  feed.Clear();
  EXPECT_FALSE(feed.Newest("pose.position.y"));
}

TEST(NumberFeed, CanBeReadWhileMessagesArrive) {
  NumberFeed feed(std::chrono::seconds(10));
  const auto schema = SchemaFor<foxglove::PoseInFrame>();
  feed.Watch("pose.position.x");
  {
    const std::jthread sender([&](const std::stop_token& stop) {
      for (std::int64_t i = 1; !stop.stop_requested(); ++i) feed.Add(RawOf(PoseAt(1), schema), {i});
    });
    for (int i = 0; i < 200; ++i) {
      feed.Watch("pose.position.y");
      (void)feed.Look("pose.position.x", {0}, kLate, 100);
      feed.Forget("pose.position.y");
    }
  }
  feed.Add(RawOf(PoseAt(4), schema), kLate);
  EXPECT_EQ(feed.Look("pose.position.x", {0}, {kLate.nanoseconds + 1}, 1).newest, 4);
}

}  // namespace
}  // namespace hgros::viewer
