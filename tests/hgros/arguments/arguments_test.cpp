#include "arguments/arguments.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace hgros::cli {
namespace {

using testing::ElementsAre;
using testing::ElementsAreArray;
using testing::HasSubstr;
using testing::ThrowsMessage;

// A command line with a flag, two options and any number of values.
struct ReadArguments {
  explicit ReadArguments(const std::vector<std::string>& words) {
    Arguments arguments;
    arguments.Flag("-f,--flag", flag, "A flag");
    arguments.Option("-o,--one", "TEXT", one, "One text");
    arguments.Option("-m,--many", "TEXT", many, "Several texts");
    arguments.Positional({"VALUE", "", "Values"}, values);
    arguments.Parse(words);
  }
  bool flag = false;
  std::string one;
  std::vector<std::string> many;
  std::vector<std::string> values;
};

TEST(Arguments, TakeEachValueAsItIs) {
  const std::vector<std::string> texts{"{}", "%%", "++", "[1, 2]", "[]", "-1.5", "", "-", "=", "\x01x", "a b"};
  const ReadArguments read(texts);
  EXPECT_THAT(read.values, ElementsAreArray(texts));
  for (const std::string& text : texts) {
    EXPECT_EQ(ReadArguments({"--one=" + text}).one, text);
    EXPECT_EQ(ReadArguments({"-o", text}).one, text);
    EXPECT_THAT(ReadArguments({"--many", text, "--many=" + text}).many, ElementsAre(text, text));
  }
}

TEST(Arguments, TakeOptionsForValuesBehindTheirEnd) {
  const ReadArguments read({"--flag", "-o3", "--", "--one=x", "--", "-f"});
  EXPECT_TRUE(read.flag);
  EXPECT_EQ(read.one, "3");
  EXPECT_THAT(read.values, ElementsAre("--one=x", "--", "-f"));
}

TEST(Arguments, RefuseCountsThatContradictEachOther) {
  const auto count = [](const std::vector<std::string>& words) {
    std::optional<std::uint64_t> number;
    Arguments arguments;
    arguments.Count(number, "One", "N");
    arguments.Parse(words);
    return number.value_or(0);
  };
  EXPECT_EQ(count({}), 0U);
  EXPECT_EQ(count({"--once"}), 1U);
  EXPECT_EQ(count({"-n", "3"}), 3U);
  EXPECT_EQ(count({"-n", "1", "--once"}), 1U);
  EXPECT_THROW((void)count({"--once", "-n", "3"}), UsageError);
  EXPECT_THROW((void)count({"-n", "3", "--once"}), UsageError);
}

TEST(Arguments, RefuseAnEmptyName) {
  std::vector<std::string> names;
  std::string text;
  Arguments arguments;
  arguments.Positional({"CHANNEL", "", "Channels", ValueKind::kChannel, {}, true, true}, names);
  arguments.Option("--text", "TEXT", text, "A text");
  arguments.Parse(std::vector<std::string>{"a", "--text", ""});
  EXPECT_THAT(names, ElementsAre("a"));
  EXPECT_THAT(
      [&] {
        arguments.Parse(std::vector<std::string>{"a", ""});
      },
      ThrowsMessage<UsageError>(HasSubstr("CHANNEL is empty. Give it a value.")));
}

TEST(Arguments, RefuseAnOptionThatIsNone) {
  EXPECT_THAT([] { const ReadArguments read({"--fla"}); },
              ThrowsMessage<UsageError>(HasSubstr("--fla is not an option. Did you mean --flag?")));
  EXPECT_THROW(ReadArguments({"-x"}), UsageError);
  EXPECT_THROW(ReadArguments({"--one"}), UsageError);
}

TEST(Arguments, RefuseAValueForAFlag) {
  for (const std::string text : {"--flag=x", "--flag=false", "--flag="}) {
    EXPECT_THAT(
        [&] {
          const ReadArguments read({text, "--flag"});
        },
        ThrowsMessage<UsageError>(HasSubstr("--flag takes no value. Write --flag alone.")))
        << text;
  }
  EXPECT_THROW(ReadArguments({"-f=x"}), UsageError);
}

}  // namespace
}  // namespace hgros::cli
