#include "viewer/data/cut_text.hpp"

#include <gtest/gtest.h>

#include <string>

namespace hgros::viewer {
namespace {

TEST(CutText, KeepsShortTexts) {
  EXPECT_EQ(CutText(""), "");
  EXPECT_EQ(CutText(std::string(kMaxShownBytes, 'x')).size(), kMaxShownBytes);
}

TEST(CutText, CutsBetweenCharacters) {
  for (const std::string character : {"x", "\u00e4", "\u20ac", "\U0001F600"}) {
    for (std::size_t before = 0; before < 4; ++before) {
      std::string text(before, '.');
      while (text.size() < 2 * kMaxShownBytes) text += character;
      const std::size_t cut = CutText(text).size();
      EXPECT_LE(cut, kMaxShownBytes);
      EXPECT_GT(cut, kMaxShownBytes - 4);
      EXPECT_EQ((cut - before) % character.size(), 0U);
    }
  }
}

TEST(CutText, CutsInvalidUtf8) { EXPECT_GT(CutText(std::string(100'000, '\x80')).size(), kMaxShownBytes - 4); }

}  // namespace
}  // namespace hgros::viewer
