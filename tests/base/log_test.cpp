#include "hgros/base/log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "hgros/base/log_ending.hpp"
#include "support/await.hpp"

namespace hgros {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A log and what is written to it.
struct Recorder {
  std::vector<std::string> lines;
  std::vector<LogLevel> levels;
  Log log{[this](LogLevel level, std::string_view text) {
    levels.push_back(level);
    lines.emplace_back(text);
  }};
  /// A warning, at most once in this time.
  void Warn(const std::string& key, const std::string& text, milliseconds interval = hours(1)) {
    log.WriteLimited(LogLevel::kWarning, key, text, interval);
  }
};

TEST(Log, PassesLevelAndTextToTheSinkButNoLinesBelowItsLevel) {
  Recorder recorder;
  recorder.log.Write(LogLevel::kDebug, "One.");
  recorder.log.SetLevel(LogLevel::kWarning);
  recorder.log.Write(LogLevel::kInfo, "Two.");
  recorder.log.WriteLimited(LogLevel::kInfo, "key", "Three.");
  recorder.log.Write(LogLevel::kWarning, "Four.");
  recorder.log.SetLevel(LogLevel::kDebug);
  recorder.log.WriteLimited(LogLevel::kDebug, "key", "Five.");
  EXPECT_THAT(recorder.lines, ElementsAre("One.", "Four.", "Five."));
  EXPECT_THAT(recorder.levels, ElementsAre(LogLevel::kDebug, LogLevel::kWarning, LogLevel::kDebug));
}

TEST(Log, DefaultSinkShowsDebugLinesOnceThisIsTheLevel) {
  const LogSink shared = DefaultLogSink();
  Log log(shared);
  Log other(shared);
  testing::internal::CaptureStderr();
  log.Write(LogLevel::kDebug, "One.");
  log.SetLevel(LogLevel::kDebug);
  log.Write(LogLevel::kDebug, "Two.");
  other.Write(LogLevel::kDebug, "Three.");
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_THAT(said, HasSubstr("Two."));
  EXPECT_EQ(said.find("One."), std::string::npos);
  EXPECT_EQ(said.find("Three."), std::string::npos);
}

TEST(Log, EscapesLineBreaksAndControlCharacters) {
  Recorder recorder;
  recorder.log.Write(LogLevel::kError, "It threw: first\nsecond.");
  recorder.log.WriteLimited(LogLevel::kError, "key", "Channel \"a\x1b[2J\xe2\x80\xaez\".");
  EXPECT_THAT(recorder.lines, ElementsAre(R"(It threw: first\nsecond.)", R"(Channel "a\x1b[2J\u202ez".)"));
  EXPECT_THAT(recorder.levels, ElementsAre(LogLevel::kError, LogLevel::kError));
}

TEST(Log, IsSilentWithoutASink) {
  Log log(nullptr);
  log.Write(LogLevel::kError, "Nobody hears.");
  log.WriteLimited(LogLevel::kError, "key", "Nobody hears.");
}

TEST(Log, WritesOncePerKeyAndInterval) {
  Recorder recorder;
  for (int i = 0; i < 5; ++i) {
    recorder.Warn("a", "A.");
    recorder.Warn("b", "B.", milliseconds::max());
  }
  EXPECT_THAT(recorder.lines, ElementsAre("A.", "B."));
}

TEST(Log, AddsTheNumberOfSuppressedLinesToTheNextLine) {
  Recorder recorder;
  for (int i = 0; i < 4; ++i) recorder.Warn("a", "A.");
  recorder.Warn("a", "A.", milliseconds(0));
  recorder.Warn("a", "A.", milliseconds(0));
  EXPECT_THAT(recorder.lines, ElementsAre("A.", "A. (and 3 times more since the last such line)", "A."));
}

TEST(Log, WritesTenAlikeLinesAndThenCounts) {
  Recorder recorder;
  for (int i = 1; i <= 50; ++i) recorder.Warn("peers", "Peer " + std::to_string(i));
  ASSERT_EQ(recorder.lines.size(), 10U);
  EXPECT_EQ(recorder.lines.back(), "Peer 10");
  LogEnding(recorder.log).WriteHeldBack();
  LogEnding(recorder.log).WriteHeldBack();
  ASSERT_EQ(recorder.lines.size(), 11U);
  EXPECT_EQ(recorder.lines.back(), "40 more lines like this one were not written: Peer 10");
  EXPECT_EQ(recorder.levels.back(), LogLevel::kWarning);
}

TEST(Log, WritesAHundredLinesOfABurstOfOneKindAndThenCounts) {
  Recorder recorder;
  const auto write = [&](const std::string& kind, int channel, milliseconds interval) {
    recorder.Warn(kind + " channel " + std::to_string(channel), kind + std::to_string(channel), interval);
  };
  for (int i = 1; i <= 3000; ++i) {
    write("lost", i, hours(1));
    if (i % 1000 == 0) write("back", i, hours(1));
  }
  ASSERT_EQ(recorder.lines.size(), 103U);
  EXPECT_THAT(recorder.lines, Contains("lost100"));
  EXPECT_THAT(recorder.lines, Contains("back3000"));
  write("lost", 1, milliseconds(0));
  ASSERT_EQ(recorder.lines.size(), 105U);
  EXPECT_EQ(recorder.lines.at(103), "2900 more lines like this one were not written: lost3000");
  EXPECT_EQ(recorder.lines.back(), "lost1");
}

TEST(Log, WaitsTwiceAsLongAfterEachLineBeyondTen) {
  Recorder recorder;
  int written = 0;
  const auto write = [&] { recorder.Warn("peers", "Peer " + std::to_string(++written), milliseconds(1)); };
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 10; ++i) write();
  EXPECT_EQ(recorder.lines.size(), 10U);
  // Eight more, after 1, 2, 4, ... 128 ms.
  while (recorder.lines.size() < 18 && std::chrono::steady_clock::now() < begin + test::kPatience) write();
  EXPECT_EQ(recorder.lines.size(), 18U);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, milliseconds(255));
  EXPECT_THAT(recorder.lines, Contains(HasSubstr("times more since the last such line)")));
}

TEST(Log, SaysWhatWasHeldBackWithTheNextLineOfAnyKind) {
  constexpr milliseconds kInterval(20);
  // A thread that is interrupted for longer in between writes the line again.
  for (bool in_time = false; !in_time && !HasFailure();) {
    Recorder recorder;
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < 3; ++i) recorder.Warn("a", "A.", kInterval);
    in_time = std::chrono::steady_clock::now() < begin + kInterval;
    test::Linger(kInterval + milliseconds(10));
    recorder.Warn("b", "B.");
    if (in_time) {
      EXPECT_THAT(recorder.lines, ElementsAre("A.", "B.", "2 more lines like this one were not written: A."));
    }
  }
}

TEST(Log, ForgetsTheOldestKeyWhenThereAreTooMany) {
  Recorder recorder;
  for (int i = 0; i < 1025; ++i) recorder.Warn(std::to_string(i), "New.");
  recorder.lines.clear();
  for (const char* const key : {"1024", "512"}) recorder.Warn(key, "New.");
  EXPECT_THAT(recorder.lines, ElementsAre()) << "the keys are remembered";
  recorder.Warn("0", "New.");
  EXPECT_THAT(recorder.lines, ElementsAre("New.")) << "the key was forgotten";
}

TEST(Log, SaysWhatAForgottenKeyHeldBack) {
  Recorder recorder;
  for (int i = 0; i < 3; ++i) recorder.Warn("first", "First.");
  for (int i = 0; i < 1024; ++i) recorder.log.WriteLimited(LogLevel::kInfo, std::to_string(i), "New.", hours(1));
  ASSERT_EQ(recorder.lines.size(), 1026U);
  EXPECT_EQ(recorder.lines.at(1024), "2 more lines like this one were not written: First.");
  EXPECT_EQ(recorder.levels.at(1024), LogLevel::kWarning);
}

TEST(Log, CallsTheSinkOneAtATimeAndLosesNoCount) {
  constexpr int kEach = 500;
  for (const int thread_count : {1, 2, 4}) {
    int inside = 0;  // not atomic on purpose: only one thread is in the sink at a time
    int calls = 0;
    Log log([&](LogLevel, std::string_view) {
      EXPECT_EQ(++inside, 1);
      ++calls;
      --inside;
    });
    {
      std::vector<std::jthread> threads;
      for (int t = 0; t < thread_count; ++t) {
        threads.emplace_back([&] {
          for (int i = 0; i < kEach; ++i) log.Write(LogLevel::kInfo, "Line.");
        });
      }
    }
    EXPECT_EQ(calls, thread_count * kEach);
  }
}

TEST(DefaultLogSink, WritesToStandardErrorOnly) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Log().Write(LogLevel::kWarning, "Braces {} are text, not a format.");
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("Braces {} are text, not a format."));
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

}  // namespace
}  // namespace hgros
