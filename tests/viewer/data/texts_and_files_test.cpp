#include <gtest/gtest.h>

#include <string>

#include "support/scratch_folder.hpp"
#include "viewer/data/cut_text.hpp"
#include "viewer/data/free_name.hpp"
#include "viewer/data/quantity_text.hpp"
#include "viewer/data/whole_file.hpp"

namespace hgros::viewer {
namespace {

using namespace std::chrono_literals;

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

TEST(FreeName, IsTheFirstThatIsNotTaken) {
  const hgros::test::ScratchFolder folder;
  EXPECT_EQ(FreeName(folder / "layout.yaml"), folder / "layout.yaml");
  folder.Write("layout.yaml", "mine");
  EXPECT_EQ(FreeName(folder / "layout.yaml"), folder / "layout-2.yaml");
  std::filesystem::create_symlink("nowhere", folder / "layout-2.yaml");
  EXPECT_EQ(FreeName(folder / "layout.yaml"), folder / "layout-3.yaml") << "a link is taken, too";
  folder.Write("plain", "mine");
  EXPECT_EQ(FreeName(folder / "plain"), folder / "plain-2");
}

TEST(QuantityText, WritesThreeSignificantDigitsAndAUnit) {
  EXPECT_EQ(ByteRateText(0), "0 B/s");
  EXPECT_EQ(ByteRateText(340), "340 B/s");
  EXPECT_EQ(ByteRateText(1250), "1.25 kB/s");
  EXPECT_EQ(ByteRateText(40.25e6), "40.2 MB/s");
  EXPECT_EQ(ByteRateText(1.5e9), "1.50 GB/s");
  EXPECT_EQ(RateText(0), "0 Hz");
  EXPECT_EQ(RateText(0.05), "0.05 Hz");
  EXPECT_EQ(RateText(9.999), "10.0 Hz");
  EXPECT_EQ(RateText(1000), "1000 Hz");
}

TEST(QuantityText, ChoosesTheUnitOfADuration) {
  EXPECT_EQ(DurationText(340us), "340 us");
  EXPECT_EQ(DurationText(1250us), "1.25 ms");
  EXPECT_EQ(DurationText(12500ms), "12.5 s");
  EXPECT_EQ(DurationText(180s), "3 min");
  EXPECT_EQ(DurationText(-2ms), "-2.00 ms") << "the sender's clock may be ahead";
}

TEST(QuantityText, UsesSingularAndPlural) {
  EXPECT_EQ(Counted(1, "message", "messages"), "1 message");
  EXPECT_EQ(Counted(0, "message", "messages"), "0 messages");
  EXPECT_EQ(Counted(12, "entity", "entities"), "12 entities");
}

TEST(WholeFile, ReadsAllBytesOfARegularFile) {
  const hgros::test::ScratchFolder folder;
  const std::string bytes("a\0b\r\n", 5);
  EXPECT_EQ(ReadWholeFile(folder.Write("file", bytes)), bytes);
  EXPECT_EQ(ReadWholeFile(folder.Write("empty", "")), "");
  EXPECT_FALSE(ReadWholeFile(folder / "nothing"));
  EXPECT_FALSE(ReadWholeFile(folder.path())) << "a folder";
  EXPECT_FALSE(ReadWholeFile("/dev/zero"));
}

}  // namespace
}  // namespace hgros::viewer
