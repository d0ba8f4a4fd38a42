// Large messages between sessions: over shared memory, over ZeroMQ, and inside one process.
#include <cstring>

#include <foxglove/PointCloud.pb.h>

#include "session/observed_fixture.hpp"

namespace hgros::test::bulk_session_test {
namespace {

using foxglove::PointCloud;
using BulkCloud = Bulk<PointCloud>;

constexpr std::size_t kSize = 300'000;

std::string Text(const PointCloud& cloud) { return cloud.data(); }
std::string Text(const BulkCloud& cloud) { return std::string(AsText(cloud.bytes())); }
const PointCloud& Head(const PointCloud& cloud) { return cloud; }
const PointCloud& Head(const BulkCloud& cloud) { return cloud.head(); }

std::unique_ptr<BulkCloud> Lent(Robot& talker, char value, std::size_t size = kSize) {
  auto cloud = talker->Loan<BulkCloud>("cloud", size);
  cloud->head().set_frame_id("lidar");
  cloud->head().set_point_stride(16);
  std::memset(cloud->writable().data(), value, cloud->writable().size());
  return cloud;
}

std::unique_ptr<PointCloud> Plain(char value) {
  auto cloud = std::make_unique<PointCloud>();
  cloud->set_frame_id("lidar");
  cloud->set_point_stride(16);
  cloud->set_data(std::string(kSize, value));
  return cloud;
}

ChannelTraffic TrafficOf(const Robot& robot) { return robot->Snapshot().traffic.at(0); }

ChannelSnapshot ChannelOf(const Robot& robot) {
  for (ChannelSnapshot& channel : robot->Snapshot().graph.channels) {
    if (channel.name == "cloud") return std::move(channel);
  }
  return {};
}

class BulkSession : public ObservedFixture {
 protected:
  BulkSession() { Begin(); }
  [[nodiscard]] Robot& talker() { return *robot; }
  [[nodiscard]] Robot& listener() { return *observer; }
  [[nodiscard]] bool shared() const { return GetParam() == "sharedmemory"; }
  [[nodiscard]] bool Joined() { return talker()->WaitForSubscribers("cloud", 1, kPatience); }
};

template <class Sent, class Got>
void ExpectArrives(Robot& talker, const Kept<Got>& kept, std::unique_ptr<Sent> cloud) {
  const std::string text = Text(*cloud);
  const std::size_t before = kept.size();
  ASSERT_EQ(talker->ToAny("cloud", std::move(cloud)), PublishStatus::kOk);
  ASSERT_TRUE(kept.AwaitSize(before + 1));
  EXPECT_TRUE(Text(*kept.at(before)) == text);
  EXPECT_EQ(Head(*kept.at(before)).frame_id(), "lidar");
  EXPECT_EQ(Head(*kept.at(before)).point_stride(), 16U);
}

TEST_P(BulkSession, PublishesALoanThatIsViewedWithoutACopy) {
  Kept<BulkCloud> kept;
  const auto subscription = listener()->FromAny<BulkCloud>("cloud", kSerial, std::ref(kept));
  (void)talker()->Advertise<BulkCloud>("cloud");
  ASSERT_TRUE(Joined());
  for (const char value : {'a', 'b', 'c'}) ExpectArrives(talker(), kept, Lent(talker(), value));
  EXPECT_EQ(TrafficOf(talker()).out.copied, 0U);
  EXPECT_EQ(TrafficOf(talker()).loans, 3U);
  EXPECT_EQ(TrafficOf(talker()).heap_loans, shared() ? 0U : 3U);
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_TRUE(kept.at(i)->head().data().empty());
  // One with a large head is copied once, and counted.
  auto large = Lent(talker(), 'd');
  large->head().set_frame_id(std::string(5000, 'f'));
  ASSERT_EQ(talker()->ToAny("cloud", std::move(large)), PublishStatus::kOk);
  ASSERT_TRUE(kept.AwaitSize(4));
  EXPECT_EQ(kept.at(3)->head().frame_id().size(), 5000U);
  EXPECT_TRUE(Text(*kept.at(3)) == std::string(kSize, 'd'));
  EXPECT_EQ(TrafficOf(talker()).out.copied, 1U);
  // One that contradicts itself is not sent, but counted.
  auto odd = Lent(talker(), 'e');
  odd->head().set_data("others");
  EXPECT_EQ(talker()->ToAny("cloud", std::move(odd)), PublishStatus::kOk);
  ExpectArrives(talker(), kept, Lent(talker(), 'f'));
  EXPECT_EQ(TrafficOf(talker()).not_encodable, 1U);
  EXPECT_TRUE(talker().Said("could not be written as foxglove.PointCloud"));
}

TEST_P(BulkSession, PlainSubscriberReceivesBulkMessages) {
  Kept<PointCloud> kept;
  const auto subscription = listener()->FromAny<PointCloud>("cloud", kSerial, std::ref(kept));
  (void)talker()->Advertise<BulkCloud>("cloud");
  ASSERT_TRUE(Joined());
  for (const std::size_t size : {kSize, std::size_t{0}, std::size_t{1}}) {
    ExpectArrives(talker(), kept, Lent(talker(), 'a', size));
  }
  EXPECT_EQ(ChannelOf(listener()).converted, 0U) << "it is decoded as the subscriber's type";
}

TEST_P(BulkSession, BulkSubscriberReceivesPlainMessages) {
  Kept<BulkCloud> kept;
  const auto subscription = listener()->FromAny<BulkCloud>("cloud", kSerial, std::ref(kept));
  (void)talker()->Advertise<PointCloud>("cloud");
  ASSERT_TRUE(Joined());
  ExpectArrives(talker(), kept, Plain('a'));
  EXPECT_EQ(ChannelOf(listener()).converted, 0U);
}

TEST_P(BulkSession, BulkAndPlainTypesMayShareOneChannel) {
  Kept<BulkCloud> bulk;
  Kept<PointCloud> plain;
  const auto one = listener()->FromAny<PointCloud>("cloud", kSerial, std::ref(plain));
  const auto two = listener()->FromAny<BulkCloud>("cloud", kSerial, std::ref(bulk));
  const auto publish_plain = talker()->Advertise<PointCloud>("cloud");
  const auto publish_bulk = talker()->Advertise<BulkCloud>("cloud");
  ASSERT_TRUE(Joined());
  ASSERT_EQ(publish_plain(Plain('a')), PublishStatus::kOk);
  ASSERT_EQ(publish_bulk(Lent(talker(), 'b')), PublishStatus::kOk);
  ASSERT_TRUE(bulk.AwaitSize(2) && plain.AwaitSize(2));
  for (const std::size_t i : {0U, 1U}) {
    EXPECT_TRUE(Text(*bulk.at(i)) == std::string(kSize, i == 0 ? 'a' : 'b'));
    EXPECT_TRUE(Text(*plain.at(i)) == Text(*bulk.at(i)));
    EXPECT_TRUE(bulk.at(i)->head().data().empty()) << "it is viewed in place, not converted from the plain message";
  }
  EXPECT_EQ(ChannelOf(listener()).converted, 2U);
  EXPECT_EQ(TrafficOf(talker()).out.copied, 0U);
}

TEST_P(BulkSession, LatchedMessagesReachALateSubscriber) {
  const auto publish = talker()->Advertise<BulkCloud>("cloud", {.latched = 2});
  for (const char value : {'a', 'b', 'c'}) ASSERT_EQ(publish(Lent(talker(), value)), PublishStatus::kOk);
  Kept<BulkCloud> kept;
  const auto subscription = listener()->FromAny<BulkCloud>("cloud", kSerial, std::ref(kept));
  ASSERT_TRUE(kept.AwaitSize(2));
  EXPECT_TRUE(Text(*kept.at(0)) == std::string(kSize, 'b'));
  EXPECT_TRUE(Text(*kept.at(1)) == std::string(kSize, 'c'));
}

TEST_P(BulkSession, KeptMessagesStayReadableAndNoneIsLost) {
  Kept<BulkCloud> kept;
  const auto subscription =
      listener()->FromAny<BulkCloud>("cloud", kSerial, std::ref(kept), {.queue = Queue::KeepAll(8)});
  const auto publish = talker()->Advertise<BulkCloud>("cloud");
  ASSERT_TRUE(Joined());
  constexpr std::size_t kCount = 40;
  for (std::size_t i = 0; i < kCount; ++i) {
    ASSERT_EQ(publish.Wait(Lent(talker(), static_cast<char>('A' + i)), std::chrono::steady_clock::now() + kPatience),
              PublishStatus::kOk);
  }
  ASSERT_TRUE(kept.AwaitSize(kCount));
  for (std::size_t i = 0; i < kCount; ++i) {
    EXPECT_TRUE(Text(*kept.at(i)) == std::string(kSize, static_cast<char>('A' + i))) << i;
  }
  EXPECT_EQ(TrafficOf(talker()).out.copied, 0U);
}

INSTANTIATE_TEST_SUITE_P(Over, BulkSession, testing::Values("sharedmemory", "ipc", "tcp"), TransportName);

using BulkSharedMemory = DomainFixture;

TEST_F(BulkSharedMemory, ReceiversReadTheMemoryThatThePublisherWrote) {
  Robot talker(""), first(""), second("");
  Kept<BulkCloud> at_first, at_second;
  const auto one = first->FromAny<BulkCloud>("cloud", kSerial, std::ref(at_first));
  const auto two = second->FromAny<BulkCloud>("cloud", kSerial, std::ref(at_second));
  (void)talker->Advertise<BulkCloud>("cloud");
  ASSERT_TRUE(talker->WaitForSubscribers("cloud", 2, kPatience));
  auto cloud = Lent(talker, 'a');
  std::byte* const written = cloud->writable().data();
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(written) % 64, 0U);
  ASSERT_EQ(talker->ToAny("cloud", std::move(cloud)), PublishStatus::kOk);
  ASSERT_TRUE(at_first.AwaitSize(1) && at_second.AwaitSize(1));
  // Writes through the publisher's mapping of the same memory. Only a test may do this.
  written[5] = std::byte{'z'};
  for (const auto* kept : {&at_first, &at_second}) {
    EXPECT_EQ(kept->at(0)->bytes()[5], std::byte{'z'});
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(kept->at(0)->bytes().data()) % 64, 0U);
  }
}

TEST_F(BulkSharedMemory, LoansComeFromTheHeapWhenSharedMemoryIsUsedUp) {
  Robot talker("shared_memory: {limit_bytes: 2000000}"), listener("");
  Kept<BulkCloud> kept;
  const auto subscription =
      listener->FromAny<BulkCloud>("cloud", kSerial, std::ref(kept), {.queue = Queue::KeepAll(100)});
  const auto publish = talker->Advertise<BulkCloud>("cloud");
  ASSERT_TRUE(talker->WaitForSubscribers("cloud", 1, kPatience));
  constexpr std::size_t kCount = 20;
  for (std::size_t i = 0; i < kCount; ++i) {
    ASSERT_EQ(publish(Lent(talker, static_cast<char>('A' + i))), PublishStatus::kOk);
    ASSERT_TRUE(kept.AwaitSize(i + 1)) << "a receiver that keeps all messages does not block the publisher";
  }
  for (std::size_t i = 0; i < kCount; ++i) {
    EXPECT_TRUE(Text(*kept.at(i)) == std::string(kSize, static_cast<char>('A' + i))) << i;
  }
  const ChannelTraffic traffic = TrafficOf(talker);
  EXPECT_EQ(traffic.loans, kCount);
  EXPECT_GT(traffic.heap_loans, 10U);
  EXPECT_LT(traffic.heap_loans, kCount);
  EXPECT_EQ(traffic.out.copied, traffic.heap_loans);
}

TEST_F(BulkSharedMemory, TwoSessionsMayPublishOneMessageAtOnce) {
  Robot talker(""), other(""), listener("");
  Kept<BulkCloud> kept;
  const auto subscription = listener->FromAny<BulkCloud>("cloud", kSerial, std::ref(kept));
  const auto publish_one = talker->Advertise<BulkCloud>("cloud");
  const auto publish_two = other->Advertise<BulkCloud>("cloud");
  ASSERT_TRUE(talker->WaitForSubscribers("cloud", 1, kPatience));
  ASSERT_TRUE(other->WaitForSubscribers("cloud", 1, kPatience));
  for (std::size_t round = 1; round <= 10; ++round) {
    const std::shared_ptr<const BulkCloud> cloud = Lent(talker, 'a');
    {
      const std::jthread one([&] { EXPECT_EQ(publish_one(cloud), PublishStatus::kOk); });
      EXPECT_EQ(publish_two(cloud), PublishStatus::kOk);
    }
    ASSERT_TRUE(kept.AwaitSize(2 * round));
  }
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_TRUE(Text(*kept.at(i)) == std::string(kSize, 'a'));
  EXPECT_EQ(TrafficOf(talker).out.copied, 0U);
  EXPECT_EQ(TrafficOf(other).out.copied, 10U) << "the message is in the other session's memory";
}

}  // namespace
}  // namespace hgros::test::bulk_session_test
