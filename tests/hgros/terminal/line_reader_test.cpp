#include "terminal/line_reader.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <string>
#include <vector>

#include "arguments/command.hpp"
#include "hgros/base/error.hpp"
#include "support/await.hpp"
#include "support/scratch_folder.hpp"
#include "terminal/pause.hpp"

namespace hgros::cli {
namespace {

std::vector<std::string> LinesIn(const std::string& text, std::size_t most_bytes = 1 << 20) {
  const test::ScratchFolder folder;
  Pause pause;
  LineReader reader(folder.Write("lines", text), most_bytes);
  std::vector<std::string> lines;
  while (const auto line = reader.Next(pause, std::chrono::steady_clock::now() + test::kPatience)) {
    lines.emplace_back(*line);
    EXPECT_EQ(reader.number(), static_cast<int>(lines.size()));
  }
  EXPECT_FALSE(reader.Next(pause, std::chrono::steady_clock::now() + test::kPatience));
  return lines;
}

TEST(LineReader, ReadsLinesWithAndWithoutALastLineBreak) {
  using Lines = std::vector<std::string>;
  EXPECT_EQ(LinesIn(""), Lines{});
  EXPECT_EQ(LinesIn("\n"), Lines{""});
  EXPECT_EQ(LinesIn("a\n\nb"), (Lines{"a", "", "b"}));
  EXPECT_EQ(LinesIn("a\nb\n"), (Lines{"a", "b"}));
}

TEST(LineReader, ReadsLinesThatAreLongerThanItsBlocks) {
  std::string text;
  std::vector<std::string> lines;
  for (std::size_t size = 1; size < 400'000; size = size * 3 + 1) {
    lines.emplace_back(size, static_cast<char>('a' + lines.size()));
    text += lines.back() + "\n";
  }
  EXPECT_EQ(LinesIn(text), lines);
}

TEST(LineReader, RefusesALineThatIsTooLong) {
  EXPECT_THROW((void)LinesIn("ab\n" + std::string(3'000'000, 'x')), Error);
  EXPECT_THROW((void)LinesIn("ab\n" + std::string(1'100'000, 'x') + "\n"), Error);
  EXPECT_THROW((void)LinesIn("ab\nabcd\n", 3), Error);
  EXPECT_EQ(LinesIn("ab\nabc\n", 3).size(), 2U);
}

TEST(LineReader, EndsWhenTheNextLineDoesNotComeInTime) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  ASSERT_EQ(write(ends[1], "a\nb", 3), 3);
  Pause pause;
  LineReader reader("/dev/fd/" + std::to_string(ends[0]), 100);
  EXPECT_EQ(reader.Next(pause, std::chrono::steady_clock::now() + test::kPatience), "a");
  pause.Wake();  // As a message that comes meanwhile.
  const auto soon = std::chrono::steady_clock::now() + std::chrono::milliseconds(100);
  EXPECT_THROW((void)reader.Next(pause, soon), TimedOut);
  for (const int end : ends) close(end);
}

TEST(LineReader, RefusesAFileThatDoesNotExist) { EXPECT_THROW(LineReader("/no/such/file", 1), UsageError); }

}  // namespace
}  // namespace hgros::cli
