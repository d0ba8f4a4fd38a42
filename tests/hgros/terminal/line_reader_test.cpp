#include "terminal/line_reader.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "arguments/arguments.hpp"
#include "hgros/base/error.hpp"
#include "hgros/proto_folder.hpp"
#include "terminal/pause.hpp"

namespace hgros::cli {
namespace {

std::vector<std::string> LinesIn(const std::string& text, std::size_t most_bytes = 1 << 20) {
  const ProtoFolder folder;
  Pause pause;
  LineReader reader(folder.Write("lines", text), most_bytes);
  std::vector<std::string> lines;
  while (const auto line = reader.Next(pause)) {
    lines.emplace_back(*line);
    EXPECT_EQ(reader.number(), static_cast<int>(lines.size()));
  }
  EXPECT_FALSE(reader.Next(pause));
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

TEST(LineReader, RefusesAFileThatDoesNotExist) { EXPECT_THROW(LineReader("/no/such/file", 1), UsageError); }

}  // namespace
}  // namespace hgros::cli
