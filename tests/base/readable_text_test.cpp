#include "hgros/base/readable_text.hpp"

#include <gtest/gtest.h>

namespace hgros {
namespace {

TEST(ReadableText, KeepsTextOfAllLanguages) {
  for (const std::string text : {"", "scan", "two words", "cam\xc3\xa9ra", "\xe6\xbf\x80\xe5\x85\x89",
                                 "\xd8\xb9\xd8\xb1\xd8\xa8", "\xf0\x9f\xa4\x96"}) {
    EXPECT_TRUE(IsReadable(text)) << text;
    EXPECT_EQ(Readable(text), text);
  }
}

TEST(ReadableText, EscapesControlCharactersAndLineBreaks) {
  EXPECT_EQ(Readable("a\nb\r\tc"), R"(a\nb\r\tc)");
  EXPECT_EQ(Readable("\x1b[31m\x7f"), R"(\x1b[31m\x7f)");
  EXPECT_EQ(Readable("a\xe2\x80\xa8\xe2\x80\xa9"), R"(a\u2028\u2029)") << "separators of lines and paragraphs";
  EXPECT_TRUE(IsReadable("\xe2\x80\xa7")) << "their neighbor U+2027";
  EXPECT_EQ(Readable(std::string_view("\0", 1)), R"(\x00)");
  EXPECT_EQ(Readable("\xc2\x80-\xc2\x9f"), R"(\u0080-\u009f)");
  EXPECT_EQ(Readable("\xc2\xa0"), "\xc2\xa0") << "U+00A0 is a space";
}

TEST(ReadableText, EscapesCharactersThatChangeTheDirectionOfText) {
  EXPECT_EQ(Readable("\xe2\x80\xaa\xe2\x80\xae"), R"(\u202a\u202e)");
  EXPECT_EQ(Readable("\xe2\x81\xa6\xe2\x81\xa9"), R"(\u2066\u2069)");
  EXPECT_TRUE(IsReadable("\xe2\x80\xaf\xe2\x81\xaa")) << "their neighbors U+202F and U+206A";
}

TEST(ReadableText, EscapesBytesThatAreNoUtf8) {
  EXPECT_EQ(Readable("a\xff\xc3"), R"(a\xff\xc3)");
  EXPECT_EQ(Readable("\xed\xa0\x80"), R"(\xed\xa0\x80)");
}

TEST(ReadableText, StaysAsItIsIfItIsUtf8) {
  for (const char* text : {"", "two\nlines\x1b", "caf\xc3\xa9", "\xf4\x8f\xbf\xbf"}) {
    EXPECT_TRUE(IsUtf8(text)) << text;
    EXPECT_EQ(AsUtf8(text), text);
  }
  for (const char* text : {"caf\xe9", "\xc3", "\xff", "\xed\xa0\x80"}) EXPECT_FALSE(IsUtf8(text)) << text;
  EXPECT_EQ(AsUtf8("caf\xe9\n"), R"(caf\xe9\n)");
}

TEST(ReadableText, IsCutAtAWholeCharacter) {
  EXPECT_EQ(Readable("abc", 2), "ab");
  EXPECT_EQ(Readable("a\xc3\xa9", 2), "a");
  EXPECT_EQ(Readable("a\x1b", 4), "a");
  EXPECT_EQ(Readable("a\x1b", 5), R"(a\x1b)");
}

}  // namespace
}  // namespace hgros
