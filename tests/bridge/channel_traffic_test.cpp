// Lost and refused messages are counted in the traffic of the channel.
#include "session/session_fixture.hpp"

namespace hgros::test {
namespace {

ChannelTraffic TrafficOf(const Robot& robot, const std::string& channel) {
  for (ChannelTraffic& traffic : robot->Snapshot().traffic) {
    if (traffic.channel == channel) return std::move(traffic);
  }
  return {};
}

class ChannelTrafficTest : public testing::Test {
 protected:
  const Bus bus{};
  Robot talker{bus.Publishing("a")};
  Robot listener{bus.Subscribing("a")};
  Notes notes;
  const Publisher<Note> publish = talker->Advertise<Note>("notes");
};

TEST_F(ChannelTrafficTest, CountsMessagesThatASlowKeepLastSubscriberMisses) {
  Door door;
  std::atomic<int> got{0};
  const auto subscription = listener->FromAny<Note>("notes", kSerial,
                                                    [&](const Note&) {
                                                      if (got++ > 0) door.Pass();
                                                    },
                                                    {{}, Queue::KeepLast(2), Executor::Inline()});
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  // A gap can only be detected after a first message.
  ASSERT_EQ(publish(std::make_unique<Note>("first")), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return got == 1; }));
  constexpr std::uint64_t kCount = 500;
  for (std::uint64_t i = 1; i < kCount; ++i) ASSERT_EQ(publish(std::make_unique<Note>("x")), PublishStatus::kOk);
  door.Open();
  const auto accounted = [&] {
    const ChannelTraffic traffic = TrafficOf(listener, "notes");
    return traffic.in.size() == 1 && traffic.in[0].received + traffic.in[0].lost == kCount;
  };
  EXPECT_TRUE(Await(accounted)) << "every message was received or is counted as lost";
  EXPECT_GT(TrafficOf(listener, "notes").in[0].lost, 0U);
  EXPECT_EQ(TrafficOf(talker, "notes").out.dropped, TrafficOf(listener, "notes").in[0].lost);
}

TEST_F(ChannelTrafficTest, CountsTheBytesOfAMessageOnceForAllSubscribersAndMeasuresItsTransportTime) {
  Robot other(bus.Subscribing("a"));
  Notes also;
  ASSERT_EQ(publish(std::make_unique<Note>("nobody listens")), PublishStatus::kOk);
  EXPECT_EQ(TrafficOf(talker, "notes").encoded, 0U);
  const auto first = listener->FromAny<Note>("notes", kSerial, std::ref(notes));
  const auto second = other->FromAny<Note>("notes", kSerial, std::ref(also));
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 2, kPatience));
  ASSERT_EQ(publish(std::make_unique<Note>("four")), PublishStatus::kOk);
  ASSERT_EQ(publish(std::make_unique<Note>("sevenup")), PublishStatus::kOk);
  const ChannelTraffic traffic = TrafficOf(talker, "notes");
  EXPECT_EQ(traffic.encoded, 2U);
  EXPECT_EQ(traffic.encoded_bytes, 11U);
  ASSERT_TRUE(Await([&] { return notes.size() == 2; }));
  EXPECT_EQ(TrafficOf(listener, "notes").transport.count(), 2U);
}

TEST_F(ChannelTrafficTest, CountsMessagesThatCannotBeEncodedOrDecoded) {
  const auto subscription = listener->FromAny<Note>("notes", kSerial, std::ref(notes));
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  for (const char* text : {"unwritable", "unreadable", "good"}) {
    EXPECT_EQ(publish(std::make_unique<Note>(text)), PublishStatus::kOk);
  }
  ASSERT_TRUE(Await([&] { return notes.size() == 1; }));
  EXPECT_EQ(notes.texts()[0], "good");
  EXPECT_EQ(TrafficOf(talker, "notes").not_encodable, 1U);
  const ChannelTraffic in = TrafficOf(listener, "notes");
  EXPECT_EQ(in.faults[static_cast<std::size_t>(PacketFault::kData)], 1U);
  EXPECT_EQ(in.in[0].lost, 0U);
  EXPECT_TRUE(listener.Said("notes"));
}

}  // namespace
}  // namespace hgros::test
