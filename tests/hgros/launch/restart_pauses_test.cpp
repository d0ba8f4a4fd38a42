#include "launch/restart_pauses.hpp"

#include <gtest/gtest.h>

namespace hgros::cli {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr RestartPauses::Clock::time_point kStart{seconds(1000)};

TEST(RestartPauses, GrowAndEndWithinAMinute) {
  RestartPauses pauses;
  EXPECT_EQ(pauses.Next(kStart), milliseconds(0));
  EXPECT_EQ(pauses.Next(kStart + seconds(1)), milliseconds(100));
  EXPECT_EQ(pauses.Next(kStart + seconds(2)), milliseconds(200));
  EXPECT_EQ(pauses.Next(kStart + seconds(3)), milliseconds(400));
  EXPECT_EQ(pauses.Next(kStart + seconds(4)), milliseconds(800));
  EXPECT_EQ(pauses.Next(kStart + seconds(5)), std::nullopt);
  EXPECT_EQ(pauses.Next(kStart + seconds(59)), std::nullopt);
}

TEST(RestartPauses, ForgetWhatIsAMinuteOld) {
  RestartPauses pauses;
  for (int i = 0; i < 5; ++i) (void)pauses.Next(kStart + seconds(i));
  EXPECT_EQ(pauses.Next(kStart + milliseconds(60'001)), milliseconds(800)) << "The first one no longer counts.";
  EXPECT_EQ(pauses.Next(kStart + seconds(200)), milliseconds(0));
}

TEST(RestartPauses, AttemptsToReachAHostAreNoRestarts) {
  RestartPauses pauses;
  for (const int pause : {1, 2, 4, 8, 16, 32, 60, 60, 60}) EXPECT_EQ(pauses.NextAttempt(), seconds(pause));
  EXPECT_EQ(pauses.Next(kStart), milliseconds(0));
  EXPECT_EQ(pauses.NextAttempt(), seconds(1));
}

TEST(RestartPauses, BeginAgainOnRequest) {
  RestartPauses pauses;
  for (int i = 0; i < 5; ++i) (void)pauses.Next(kStart);
  pauses.Forget();
  EXPECT_EQ(pauses.Next(kStart), milliseconds(0));
}

}  // namespace
}  // namespace hgros::cli
