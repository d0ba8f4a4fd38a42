#include <gtest/gtest.h>

#include "transport/zmq/clock_question.hpp"

namespace hgros::zmq {
namespace {

TEST(ZmqClockQuestion, IsAnsweredAtOnceWithFourTimes) {
  ClockQuestion question;
  wire::Heartbeat asking;
  question.Ask(asking, Time{1000});
  const auto answer = AnswerTo(asking, Time{70});
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->asked_ns(), 0) << "an answer must not ask";
  const auto exchange = question.Read(*answer, Time{1030});
  ASSERT_TRUE(exchange);
  EXPECT_EQ(exchange->asked, Time{1000});
  EXPECT_EQ(exchange->received, Time{70});
  EXPECT_EQ(exchange->answered, Time{70});
  EXPECT_EQ(exchange->got, Time{1030});
}

TEST(ZmqClockQuestion, TakesTheAnswerToItsLatestQuestionOnce) {
  ClockQuestion question;
  wire::Heartbeat first;
  wire::Heartbeat second;
  question.Ask(first, Time{1000});
  const auto late = AnswerTo(first, Time{70});
  question.Ask(second, Time{2000});
  const auto answer = AnswerTo(second, Time{80});
  ASSERT_TRUE(late && answer);
  EXPECT_FALSE(question.Read(*late, Time{2010}));
  EXPECT_TRUE(question.Read(*answer, Time{2020}));
  EXPECT_FALSE(question.Read(*answer, Time{2030}));
}

TEST(ZmqClockQuestion, IgnoresHeartbeatsWithoutClockFields) {
  ClockQuestion question;
  EXPECT_FALSE(AnswerTo({}, Time{70}));
  EXPECT_FALSE(question.Read({}, Time{1}));
}

}  // namespace
}  // namespace hgros::zmq
