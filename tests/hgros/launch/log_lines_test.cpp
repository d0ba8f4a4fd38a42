#include "launch/log_lines.hpp"

#include <gtest/gtest.h>

#include <string>

namespace hgros::cli {
namespace {

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

}  // namespace
}  // namespace hgros::cli
