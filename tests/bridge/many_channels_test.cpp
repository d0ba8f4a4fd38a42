// Two sessions with thousands of channels between them.
#include <ctime>

#include "session/domain_fixture.hpp"
#include "transport/agreement.hpp"

namespace hgros::test::many_channels_test {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::size_t kMany = 2'000;  // More take minutes.
#else
constexpr std::size_t kMany = 10'000;
#endif

std::string Name(std::size_t i) { return "robot/sensor" + std::to_string(i); }

class ManyChannels : public DomainFixture {
 protected:
  static constexpr const char* kAlone = "discovery: {local: false}\n";
  const Bus bus{};

  // One message on each channel; each must arrive.
  static void Pass(Robot& talker, Robot& listener, std::size_t count) {
    std::atomic<std::size_t> arrived{0};
    std::vector<Subscription> subscriptions;
    std::vector<Publisher<Note>> publishers;
    for (std::size_t i = 0; i < count; ++i) {
      subscriptions.push_back(listener->FromAny<Note>(Name(i), kSerial, [&](const Note&) { ++arrived; }));
      publishers.push_back(talker->Advertise<Note>(Name(i)));
    }
    for (std::size_t i = 0; i < count; ++i) ASSERT_TRUE(talker->WaitForSubscribers(Name(i), 1, kPatience)) << Name(i);
    for (const auto& publish : publishers) EXPECT_EQ(publish(Note("one")), PublishStatus::kOk);
    EXPECT_TRUE(Await([&] { return arrived == count; })) << arrived << " of " << count;
  }

  // The listener subscribes to one channel more than it can receive from one peer.
  static void Exceed(Robot& talker, Robot& listener, const std::string& transport) {
    const auto publish = talker->Advertise<Note>(Name(0));
    std::vector<Subscription> subscriptions;
    subscriptions.push_back(listener->FromAny<Note>(Name(0), kSerial, [](const Note&) {}));
    ASSERT_TRUE(talker->WaitForSubscribers(Name(0), 1, kPatience));
    for (std::size_t i = 1; i <= kMaxChannels; ++i) {
      subscriptions.push_back(listener->FromAny<Note>(Name(i), kSerial, [](const Note&) {}));
    }
    EXPECT_TRUE(Await([&] { return listener.Said("\"" + Name(kMaxChannels) + "\" is not received from session"); }));
    EXPECT_TRUE(listener.Said("through " + transport));
    EXPECT_TRUE(listener.Said("more than 16384 channels"));
  }
};

// The CPU time of this process for a session that publishes on this number of channels and subscribes to as many
// others.
double SecondsFor(std::size_t channels, const std::string& yaml) {
  const auto now = [] {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
  };
  const double before = now();
  {
    Robot robot(yaml);
    std::vector<Subscription> subscriptions;
    for (std::size_t i = 0; i < channels; ++i) {
      (void)robot->Advertise<Note>("out" + Name(i));
      subscriptions.push_back(robot->FromAny<Note>("in" + Name(i), kSerial, [](const Note&) {}));
    }
  }
  return now() - before;
}

TEST_F(ManyChannels, WiringTakesTimeInProportionToTheirNumber) {
  const std::string yaml = "network: {publisher: {ip: 'tcp://127.0.0.1:*'}}";
  (void)SecondsFor(100, yaml);
  // Beside others, a program may use more of the processor, but not each time.
  bool proportional = false;
  double few = 0;
  double many = 0;
  for (int attempt = 0; attempt < 5 && !proportional; ++attempt) {
    few = SecondsFor(kMany / 10, yaml);
    many = SecondsFor(kMany / 10 * 8, yaml);
    proportional = many < 20 * few;
  }
  EXPECT_TRUE(proportional) << few << " s, " << many << " s for eight times as many";
}

TEST_F(ManyChannels, AllAreReceivedOverSharedMemory) {
  Robot talker(""), listener("");
  Pass(talker, listener, kMany);
}

TEST_F(ManyChannels, AllAreReceivedOverZeroMq) {
  Robot talker(bus.Publishing("a") + kAlone), listener(bus.Subscribing("a") + kAlone);
  Pass(talker, listener, kMany);
}

#ifndef __SANITIZE_THREAD__  // Two minutes, and the threads do the same as with fewer channels.

TEST_F(ManyChannels, LogSaysWhichChannelIsBeyondTheLimitOfSharedMemory) {
  Robot talker(""), listener("");
  Exceed(talker, listener, "shared memory");
}

TEST_F(ManyChannels, LogSaysWhichChannelIsBeyondTheLimitOfZeroMq) {
  Robot talker(bus.Publishing("a") + kAlone), listener(bus.Subscribing("a") + kAlone);
  Exceed(talker, listener, "ZeroMQ");
}

#endif

}  // namespace
}  // namespace hgros::test::many_channels_test
