#include "viewer/scene/displays/newest_message.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "foxglove/Log.pb.h"

namespace hgros::viewer {
namespace {

using foxglove::Log;

struct Shown {
  std::string text;
  int option = 0;
};
using Newest = NewestMessage<Log, int, Shown>;

std::string Read(const Log& log, const int& option, Shown& shown) {
  if (log.message().empty()) return "It is empty.";
  shown = {log.message(), option};
  return {};
}

Log Saying(const std::string& text) {
  Log log;
  log.set_message(text);
  return log;
}

class NewestMessageTest : public ::testing::Test {
 protected:
  /// Publishes a message and waits until it has arrived.
  void Send(const std::string& text) {
    ASSERT_EQ(session_.ToAny("log", Saying(text)), PublishStatus::kOk);
    Wait();
  }
  void Wait() { ASSERT_TRUE(session_.WaitIdle(std::chrono::seconds(10))); }

  Session session_;
  std::atomic<int> woken_ = 0;
  Newest newest_{{session_, "log", [this] { ++woken_; }}, 1, Read};
};

TEST_F(NewestMessageTest, IsTakenOnceAndOlderOnesAreDroppedAndCounted) {
  EXPECT_FALSE(newest_.Take());
  for (const char* text : {"a", "b", "c"}) Send(text);
  EXPECT_EQ(woken_, 1);
  EXPECT_EQ(newest_.Take().value().shown.text, "c");
  EXPECT_EQ(newest_.received(), 3U);
  EXPECT_EQ(newest_.dropped(), 2U);
  EXPECT_FALSE(newest_.Take());
}

TEST_F(NewestMessageTest, IsReadAgainWithNewOptions) {
  Send("a");
  EXPECT_EQ(newest_.Take()->shown.option, 1);
  newest_.SetOptions(2);
  const Shown shown = newest_.Take().value().shown;
  EXPECT_EQ(shown.text, "a");
  EXPECT_EQ(shown.option, 2);
  newest_.Clear();
  newest_.SetOptions(3);
  EXPECT_FALSE(newest_.Take());
  Send("b");
  EXPECT_EQ(newest_.Take()->shown.option, 3);
}

TEST_F(NewestMessageTest, ReportsErrors) {
  Send("");
  EXPECT_EQ(newest_.Take()->fault, "It is empty.");
}

TEST_F(NewestMessageTest, HasTheLastOptionsWhileMessagesArrive) {
  constexpr int kMessages = 2000;
  std::jthread publisher([&] {
    for (int i = 0; i < kMessages; ++i) (void)session_.ToAny("log", Saying(std::to_string(i)));
  });
  int last = -1;
  for (int option = 2; option < 500; ++option) {
    newest_.SetOptions(option);
    if (const auto read = newest_.Take()) {
      EXPECT_EQ(read->shown.option, option);
      EXPECT_GE(std::stoi(read->shown.text), last);
      last = std::stoi(read->shown.text);
    }
  }
  publisher.join();
  Wait();
  newest_.SetOptions(500);
  EXPECT_EQ(newest_.Take()->shown.text, std::to_string(kMessages - 1));
}

}  // namespace
}  // namespace hgros::viewer
