// What becomes of the messages that a session publishes last when its subscribers are far away.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <foxglove/Log.pb.h>

#include "hgros/hgros.hpp"
#include "resilience/slow_cable.hpp"
#include "support/await.hpp"
#include "support/cable.hpp"

namespace hgros::resilience {
namespace {

using foxglove::Log;
using test::Await;
using test::kPatience;

class LastMessages : public testing::Test {
 protected:
  // False: there is no such cable here.
  bool Connect(std::chrono::milliseconds each_way, double bits_per_second, Queue queue) {
    if (geteuid() != 0) return false;
    cable_.emplace(each_way, bits_per_second);
    if (!cable_->ready) return false;
    test::On(cable_->left, [this] {
      talker_.emplace(Config::Parse("{discovery: {local: false}, network: {publisher: {ip: \"tcp://*:5601\"}}}"),
                      SessionOptions{"talker", [this](LogLevel level, std::string_view text) {
                                       const std::scoped_lock lock(mutex_);
                                       if (level >= LogLevel::kWarning) warnings_.emplace_back(text);
                                     }});
    });
    test::On(cable_->right, [this] {
      listener_.emplace(Config::Parse("{discovery: {local: false}, network: {subscribers: [{ip: "
                                      "\"tcp://10.196.0.1:5601\"}]}}"),
                        SessionOptions{"listener"});
    });
    subscription_ = listener_->FromAny<Log>(
        "logs", Invoke::kSerial, [this](const Log& log) { bytes_ += log.message().size(); }, {.queue = queue});
    (void)talker_->Advertise<Log>("logs");
    EXPECT_TRUE(talker_->WaitForSubscribers("logs", 1, kPatience));
    return true;
  }
  void Publish(std::size_t messages, std::size_t bytes) {
    Log log;
    log.set_message(std::string(bytes, 'x'));
    for (std::size_t i = 0; i < messages; ++i) ASSERT_EQ(talker_->ToAny("logs", log), PublishStatus::kOk);
    published_ = messages * bytes;
  }
  void ExpectThatAllArrive() {
    talker_.reset();
    EXPECT_TRUE(Await([&] { return bytes_ >= published_; })) << bytes_ << " bytes of " << published_;
    EXPECT_EQ(bytes_, published_);
    EXPECT_EQ(Warnings(), std::vector<std::string>());
  }
  [[nodiscard]] std::vector<std::string> Warnings() {
    const std::scoped_lock lock(mutex_);
    return warnings_;
  }

  std::optional<SlowCable> cable_;
  std::mutex mutex_;
  std::vector<std::string> warnings_;  // Of the talker; guarded by mutex_.
  std::atomic<std::size_t> bytes_{0};
  std::size_t published_ = 0;
  std::optional<Session> talker_;    // On the left host.
  std::optional<Session> listener_;  // On the right host.
  Subscription subscription_;
};

constexpr const char* kNoCable = "needs root, network namespaces and TAP devices";

TEST_F(LastMessages, ReachALosslessSubscriberOverALongLine) {
  if (!Connect(std::chrono::milliseconds(20), 0, Queue::KeepAll(1000))) GTEST_SKIP() << kNoCable;
  Publish(900, 1000);
  ExpectThatAllArrive();
}

TEST_F(LastMessages, ReachAKeepLastSubscriberOverALongLine) {
  if (!Connect(std::chrono::milliseconds(20), 0, Queue::KeepLast(1000))) GTEST_SKIP() << kNoCable;
  Publish(900, 1000);
  ExpectThatAllArrive();
}

TEST_F(LastMessages, ReachALosslessSubscriberIfTheyNeedLongerThanASilentPeerMay) {
  if (!Connect(std::chrono::milliseconds(5), 20e6, Queue::KeepAll(10))) GTEST_SKIP() << kNoCable;
  Publish(1, 2'000'000);
  ExpectThatAllArrive();
}

TEST_F(LastMessages, ReachAKeepLastSubscriberIfTheyNeedLongerThanASilentPeerMay) {
  if (!Connect(std::chrono::milliseconds(5), 20e6, Queue::KeepLast(16))) GTEST_SKIP() << kNoCable;
  Publish(1, 2'000'000);
  ExpectThatAllArrive();
}

TEST_F(LastMessages, AreSaidToBeLostWithTheirNumberIfTheLineIsCut) {
  if (!Connect(std::chrono::milliseconds(5), 0, Queue::KeepAll(1000))) GTEST_SKIP() << kNoCable;
  cable_->Cut();
  Publish(30, 1000);
  talker_.reset();
  const auto warnings = Warnings();
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("up to 30 messages of lossless channels, such as \"logs\""), std::string::npos)
      << warnings[0];
  EXPECT_EQ(bytes_, 0U);
}

}  // namespace
}  // namespace hgros::resilience
