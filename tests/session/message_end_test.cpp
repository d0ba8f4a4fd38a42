// The destructor of a message is user code. It runs under no lock of the library, so it may publish.
#include "session/domain_fixture.hpp"

namespace hgros::test {
namespace {

/// Without shared memory the transports keep the message itself instead of a copy.
constexpr const char* kNoMemory = "shared_memory: {limit_bytes: 4096}\n";

class MessageEnd : public DomainFixture {
 protected:
  /// `talker` publishes to `listener`. The destructor of a message publishes another one on the same channel.
  static void Run(Robot& talker, Robot& listener) {
    std::atomic<int> received{0};
    const auto subscription = listener->FromAny<Block>("raw", Invoke::kSerial, [&](const Block&) { ++received; },
                                                       {.queue = Queue::KeepAll(16)});
    const auto publish = talker->Advertise<Block>("raw");
    ASSERT_TRUE(talker->WaitForSubscribers("raw", 1, kPatience));

    std::atomic<int> ended{0};
    std::atomic<bool> published{false};
    std::atomic<bool> in_time{false};
    std::thread another;
    const auto end = [&](std::vector<std::byte>* bytes) {
      delete bytes;
      if (ended++ > 0) return;
      another = std::thread([&] {
        (void)publish.Wait(std::make_unique<Block>(Block::Allocate(100)), std::chrono::steady_clock::now() + kPatience);
        published = true;
      });
      in_time = Await([&] { return published.load(); });
    };
    constexpr int kMessages = 10;
    for (int i = 0; i < kMessages; ++i) {
      const std::shared_ptr<std::vector<std::byte>> bytes(new std::vector<std::byte>(100'000), end);
      auto block = std::make_unique<Block>(Block::Adopt(*bytes, bytes));
      ASSERT_EQ(publish.Wait(std::move(block), std::chrono::steady_clock::now() + kPatience), PublishStatus::kOk);
      // Waits, so that the next publish finds this message consumed and releases it.
      ASSERT_TRUE(Await([&] { return received > i; }));
    }
    EXPECT_TRUE(Await([&] { return received == kMessages + 1; })) << received;
    EXPECT_TRUE(Await([&] { return in_time.load(); })) << "the destructor of a message waited for a publish";
    talker.session.reset();
    EXPECT_TRUE(Await([&] { return ended == kMessages; }));
    if (another.joinable()) another.join();
  }
};

TEST_F(MessageEnd, DestructorMayPublishOnItsOwnChannelOverAPairSocket) {
  Robot talker(kNoMemory);
  Robot listener(kNoMemory);
  Run(talker, listener);
}

TEST_F(MessageEnd, DestructorMayPublishOnItsOwnChannelOverZeroMq) {
  const Bus bus;
  Robot talker(bus.Publishing("talker") + "discovery: {local: false}");
  Robot listener(bus.Subscribing("talker") + "discovery: {local: false}");
  Run(talker, listener);
}

}  // namespace
}  // namespace hgros::test
