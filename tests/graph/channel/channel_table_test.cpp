#include "graph/channel/channel_table.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "hgros/graph/data_graph.hpp"
#include "support/await.hpp"

namespace hgros {
namespace {

TEST(ChannelTable, FindsEveryChannelWhileOthersAreAdded) {
  DataGraph graph;
  constexpr int kChannels = 1000;
  std::atomic<bool> stop{false};
  std::atomic<int> added{0};
  std::atomic<int> misses{0};
  std::jthread reader([&] {
    while (!stop) {
      const int count = added;
      for (int i = 0; i < count; ++i) {
        // The channel was opened with int, and another type is refused. No refusal shows that the channel was found.
        if (graph.ToGraph("channel" + std::to_string(i), std::make_unique<int>(i)) != PublishStatus::kOk) ++misses;
      }
    }
  });
  for (int i = 0; i < kChannels; ++i) {
    (void)graph.Advertise<int>("channel" + std::to_string(i));
    added = i + 1;
  }
  stop = true;
  reader.join();
  EXPECT_EQ(misses, 0);
  EXPECT_EQ(graph.Snapshot().channels.size(), static_cast<std::size_t>(kChannels));
}

}  // namespace
}  // namespace hgros
