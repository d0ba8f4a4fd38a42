// How numbers, texts and tables are shown.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "terminal/json.hpp"
#include "terminal/records.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

using testing::HasSubstr;

TEST(Json, EscapesWhatATerminalWouldObey) {
  Json json;
  json.BeginObject().Member("a\x1b", "\x7F\xC2\x9B\xE2\x80\xAE\xFF \xC3\xA9").EndObject();
  EXPECT_EQ(json.text(), "{\"a\\u001B\":\"\\u007F\\u009B\\u202E\\uFFFD \\u00E9\"}");
}

TEST(Units, ShowBoundsWithTheDigitsThatTellThemApart) {
  EXPECT_EQ(BoundText(100'100'000, 100'000, 101'000'000, Unit::kNanoseconds, false), "100.1 ms");
  EXPECT_EQ(BoundText(0, 200'000, 2'300'000, Unit::kNanoseconds, false), "0.0 ms");
  EXPECT_EQ(BoundText(40, 20, 900, Unit::kNanoseconds, false), "40 ns");
  EXPECT_EQ(BoundText(2'000'000, 1'000'000, 5'000'000, Unit::kBytes, false), "2 MB");
  EXPECT_EQ(BoundText(2'883, 0, 2'883, Unit::kBytes, false), "2.88 kB");
  EXPECT_EQ(BoundText(100'100'000, 100'000, 101'000'000, Unit::kNanoseconds, true), "100100000");
}

TEST(Units, ShowThreeDigits) {
  EXPECT_EQ(RateText(9.996, false), "10.0 Hz");
  EXPECT_EQ(RateText(1234.5, false), "1.23 kHz");
  EXPECT_EQ(BytesText(999, false), "999 B");
  EXPECT_EQ(BandwidthText(115'322, false), "115 kB/s");
  EXPECT_EQ(DurationText(-999, false), "-999 ns");
  EXPECT_EQ(DurationText(1'500'000'000, false), "1.50 s");
  EXPECT_EQ(DurationText(1'500, true), "1500");
}

TEST(VisibleText, EscapesWhatATerminalWouldObey) {
  EXPECT_EQ(Visible("plain"), "plain");
  EXPECT_EQ(Visible("\x1b[2J\n\t\r\x7f"), "\\x1b[2J\\n\\t\\r\\x7f");
  EXPECT_EQ(Visible("\xC2\x9B"), "\\x9b");        // CSI as one character.
  EXPECT_EQ(Visible("\xE2\x80\xAE"), "\\u202e");  // Turns the direction of text.
  EXPECT_EQ(Visible("\xEF\xBB\xBF"), "\\ufeff");  // Takes no space.
  EXPECT_EQ(Visible("gr\xC3\xBC\xC3\x9F"), "gr\xC3\xBC\xC3\x9F");
}

TEST(VisibleText, EscapesBytesThatAreNoUtf8) {
  EXPECT_EQ(Visible("a\xFFz"), "a\\xffz");
  EXPECT_EQ(Visible("\xC3"), "\\xc3");
  EXPECT_EQ(Visible("\xE2\x82"), "\\xe2\\x82");
  EXPECT_EQ(Visible("\xC0\x80"), "\\xc0\\x80");           // Too long a form of zero.
  EXPECT_EQ(Visible("\xED\xA0\x80"), "\\xed\\xa0\\x80");  // A surrogate.
  EXPECT_EQ(ValidUtf8("a\xFFz"), "a\xEF\xBF\xBDz");
}

TEST(VisibleText, CountsCharacters) {
  EXPECT_EQ(ColumnsOf("abc"), 3U);
  EXPECT_EQ(ColumnsOf("gr\xC3\xBC\xC3\x9F"), 4U);
}

std::string Table(OutputStyle style) {
  std::string text;
  Console console(text);
  Records records(console, style, {{"first", "FIRST"}, {"number", "N", true}, {"last", "LAST"}, {"hidden", ""}});
  records.Add({std::string(500, 'a'), std::uint64_t{1}, std::string(500, 'b'), std::string(500, 'c')});
  records.Add({"caf\xC3\xA9", std::uint64_t{20}, "end"});
  records.End();
  return text;
}

TEST(Records, ShortenLongTextsExceptInTheLastColumn) {
  const std::string a(77, 'a');
  const std::string space(76, ' ');
  EXPECT_EQ(Table({}), "FIRST" + std::string(75, ' ') + "   N  LAST\n" + a + "...   1  " + std::string(500, 'b') +
                           "\n" + "caf\xC3\xA9" + space + "  20  end\n");
  EXPECT_THAT(Table({.exact = true}), HasSubstr(std::string(500, 'a') + "   1  "));
  EXPECT_THAT(Table({.json = true}), HasSubstr("\"first\":\"" + std::string(500, 'a') + "\",\"number\":1"));
}

}  // namespace
}  // namespace hgros::cli
