#include <gtest/gtest.h>

#include <string>

#include "hosting/restart_pauses.hpp"
#include "launch/log_lines.hpp"

namespace hgros::cli {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(LogLinesTest, KeepsTheNewest) {
  LogLines lines;
  for (int i = 0; i < 5000; ++i) lines.Add({0, "p", {}, LogLevel::kInfo, std::to_string(i)});
  EXPECT_EQ(lines.all().size(), 2000U);
  EXPECT_EQ(lines.all().back().text, "4999");
  for (int i = 0; i < 100; ++i) lines.Add({0, "p", {}, LogLevel::kInfo, std::string(100'000, 'x')});
  EXPECT_LE(lines.all().size(), 11U);
  EXPECT_GE(lines.all().size(), 1U);
}

TEST(LogLinesTest, ShowNamesLevelsAndNothingRaw) {
  std::string ignored;
  const Console console(ignored);
  const std::string text = LineText(console, {1, "p", "map\x1b", LogLevel::kError, "a\nb"}, 6);
  EXPECT_EQ(text.substr(12), " map\\x1b  error: a\\nb");
  EXPECT_EQ(LineText(console, {1, "p", {}, LogLevel::kInfo, "x"}, 3).substr(12), " p    x");
  EXPECT_EQ(
      LineJson({7, "p", {}, LogLevel::kWarning, "x\n"}),
      "{\"event\":\"log\",\"time_ns\":7,\"process\":\"p\",\"component\":null,\"level\":\"warning\",\"text\":\"x\\n\"}");
}

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
