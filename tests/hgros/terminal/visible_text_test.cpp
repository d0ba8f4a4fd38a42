#include "terminal/visible_text.hpp"

#include <gtest/gtest.h>

namespace hgros::cli {
namespace {

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

}  // namespace
}  // namespace hgros::cli
