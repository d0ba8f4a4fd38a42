#include "viewer/data/messages/log_store.hpp"

#include <gtest/gtest.h>

#include "viewer/data/cut_text.hpp"

namespace hgros::viewer {
namespace {

using foxglove::Log;

Log Said(const std::string& text, Log::Level level = Log::INFO, const std::string& source = "node") {
  Log log;
  log.set_message(text);
  log.set_level(level);
  log.set_name(source);
  return log;
}

TEST(LogStore, KeepsTheLastLinesAndCountsTheRest) {
  LogStore store(3);
  for (int i = 0; i < 5; ++i) store.Add(Said(std::to_string(i)));
  ASSERT_EQ(store.lines().size(), 3U);
  EXPECT_EQ(store.lines().front().text, "2");
  EXPECT_EQ(store.forgotten(), 2U);
  EXPECT_EQ(store.count(Log::INFO), 5U);
  EXPECT_EQ(store.sources().at("node"), 5U);
  store.Clear();
  EXPECT_TRUE(store.lines().empty());
}

TEST(LogStore, MergesRepeatedLinesIntoOne) {
  LogStore store;
  for (int i = 0; i < 100; ++i) store.Add(Said("again", Log::WARNING));
  store.Add(Said("again", Log::ERROR));
  ASSERT_EQ(store.lines().size(), 2U);
  EXPECT_EQ(store.lines()[0].repeats, 99U);
  EXPECT_EQ(store.count(Log::WARNING), 100U);
}

TEST(LogStore, FindsByLevelSourceAndText) {
  LogStore store;
  store.Add(Said("Wheel slips", Log::WARNING, "odometry"));
  store.Add(Said("map saved", Log::INFO, "mapper"));
  store.Add(Said("wheel is lost", Log::ERROR, "odometry"));
  EXPECT_EQ(store.Find({Log::WARNING, {}, {}}, 10), (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(store.Find({Log::UNKNOWN, "mapper", {}}, 10), std::vector<std::size_t>{1});
  EXPECT_EQ(store.Find({Log::UNKNOWN, {}, "WHEEL"}, 10), (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(store.Find({}, 2), (std::vector<std::size_t>{1, 2})) << "the newest";
}

TEST(LogStore, AcceptsUnknownLevelsAndLongTexts) {
  LogStore store;
  Log log = Said(std::string(100'000, 'x'));
  log.set_level(static_cast<Log::Level>(77));
  log.set_file("a.cpp");
  log.set_line(7);
  store.Add(log);
  log.set_name(std::string(100'000, 'n'));
  log.set_file(std::string(100'000, 'f'));
  store.Add(log);
  EXPECT_EQ(store.lines()[0].level, Log::UNKNOWN);
  EXPECT_EQ(store.lines()[0].text.size(), kMaxShownBytes);
  EXPECT_EQ(store.lines()[0].place, "a.cpp:7");
  EXPECT_EQ(store.lines()[1].source.size(), kMaxShownBytes);
  EXPECT_EQ(store.lines()[1].place.size(), kMaxShownBytes + 2);
}

}  // namespace
}  // namespace hgros::viewer
