#include "viewer/app/displays/unmet_requests.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <memory>
#include <string>

#include "foxglove/PointCloud.pb.h"
#include "hgros/base/error.hpp"
#include "viewer/app/surface/offscreen.hpp"

namespace hgros::viewer::test {
namespace {

TEST(UnmetRequests, ListsOffscreenWhatWasFoundAndShowsNothing) {
  std::unique_ptr<Offscreen> surface;
  try {
    surface = std::make_unique<Offscreen>(Viewport{64, 64});
  } catch (const Error& error) {
    GTEST_SKIP() << error.what();
  }
  Session session;
  std::deque<Publisher<foxglove::PointCloud>> publishers;
  for (std::size_t i = 0; i < DisplayOpener::kMostFound + 8; ++i) {
    publishers.push_back(session.Advertise<foxglove::PointCloud>("cloud_" + std::to_string(100 + i)));
  }
  Scene scene;
  ChannelList channels;
  channels.Refresh(session);
  Notices notices;
  DisplayOpener displays(session, scene, channels, notices, [] {});
  displays.AddPublished();
  ASSERT_EQ(scene.entries().size(), DisplayOpener::kMostFound);
  ASSERT_EQ(session.ToAny(scene.entries()[5].channel, foxglove::PointCloud()), PublishStatus::kOk);
  ASSERT_TRUE(session.WaitIdle(std::chrono::seconds(10)));
  const TransformTree tree;
  FixedFrame frame(tree);
  scene.Update({frame, 0, false, false});

  Options options;
  for (const bool offscreen : {false, true}) {
    if (offscreen) options.offscreen = Viewport{64, 64};
    ::testing::internal::CaptureStderr();
    EXPECT_FALSE(PrintUnmetRequests({options, scene, channels, displays, frame, {}})) << "nothing was requested";
    const std::string said = ::testing::internal::GetCapturedStderr();
    const auto lists = [&](const std::string& words) { return said.find(words) != std::string::npos; };
    EXPECT_EQ(lists(scene.entries()[5].channel + ": "), offscreen) << said;
    EXPECT_EQ(lists("8 more channels were found and not opened"), offscreen) << said;
  }
}

}  // namespace
}  // namespace hgros::viewer::test
