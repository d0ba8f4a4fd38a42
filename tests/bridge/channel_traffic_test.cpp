// Encoded and refused messages are counted in the traffic of the channel.
#include "session/session_fixture.hpp"

namespace hgros::test {
namespace {

ChannelTraffic TrafficOf(const Robot& robot) { return robot->Snapshot().traffic.at(0); }

class ChannelTrafficTest : public testing::Test {
 protected:
  const Bus bus{};
  Robot talker{bus.Publishing("a")};
  Robot listener{bus.Subscribing("a")};
  Notes notes;
  const Publisher<Note> publish = talker->Advertise<Note>("notes");
};

TEST_F(ChannelTrafficTest, CountsTheBytesOfAMessageOnceForAllSubscribersAndMeasuresItsTransportTime) {
  Robot other(bus.Subscribing("a"));
  Notes also;
  ASSERT_EQ(publish(std::make_unique<Note>("nobody listens")), PublishStatus::kOk);
  EXPECT_EQ(TrafficOf(talker).encoded, 0U);
  Subscription first = listener->FromAny<Note>("notes", kSerial, std::ref(notes));
  Subscription second = other->FromAny<Note>("notes", kSerial, std::ref(also));
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 2, kPatience));
  ASSERT_EQ(publish(std::make_unique<Note>("four")), PublishStatus::kOk);
  ASSERT_EQ(publish(std::make_unique<Note>("sevenup")), PublishStatus::kOk);
  const ChannelTraffic traffic = TrafficOf(talker);
  EXPECT_EQ(traffic.encoded, 2U);
  EXPECT_EQ(traffic.encoded_bytes, 11U);
  ASSERT_TRUE(Await([&] { return notes.size() == 2; }));
  EXPECT_EQ(TrafficOf(listener).transport.count(), 2U);
  first.Reset();
  second.Reset();
  ASSERT_TRUE(Await([&] { return TrafficOf(talker).out.subscribers == 0; }));
  ASSERT_EQ(publish(std::make_unique<Note>("nobody listens any more")), PublishStatus::kOk);
  EXPECT_EQ(TrafficOf(talker).encoded, 2U);
}

TEST_F(ChannelTrafficTest, CountsMessagesThatCannotBeEncodedOrDecoded) {
  const auto subscription = listener->FromAny<Note>("notes", kSerial, std::ref(notes));
  ASSERT_TRUE(talker->WaitForSubscribers("notes", 1, kPatience));
  for (const char* text : {"unwritable", "unreadable", "good"}) {
    EXPECT_EQ(publish(std::make_unique<Note>(text)), PublishStatus::kOk);
  }
  ASSERT_TRUE(Await([&] { return notes.size() == 1; }));
  EXPECT_EQ(notes.texts()[0], "good");
  EXPECT_EQ(TrafficOf(talker).not_encodable, 1U);
  const ChannelTraffic in = TrafficOf(listener);
  EXPECT_EQ(in.faults[static_cast<std::size_t>(PacketFault::kData)], 1U);
  EXPECT_EQ(in.in[0].lost, 0U);
  EXPECT_TRUE(listener.Said("notes"));
}

}  // namespace
}  // namespace hgros::test
