#include "commands/commands.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <sstream>

#include "arguments/help.hpp"
#include "arguments/manual.hpp"
#include "hgros/help_examples.hpp"
#include "terminal/console.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

using testing::HasSubstr;

TEST(Commands, HaveADescriptionAndTwoExamplesThatAreRight) {
  for (const CommandEntry& entry : Commands()) {
    if (entry.family()) continue;
    const auto command = entry.make();
    EXPECT_TRUE(command->Description().ends_with('.')) << entry.name;
    const std::vector<Example> examples = command->Examples();
    EXPECT_GE(examples.size(), 2U) << entry.name;
    for (const Example& example : examples) {
      EXPECT_TRUE(example.text.ends_with('.')) << example.text;
      std::vector<std::string> words = ShellWords(example.line);
      ASSERT_EQ(words.front(), "hgros") << example.line;
      words.erase(words.begin());
      EXPECT_EQ(TakeCommand(words).name, entry.name) << example.line;
      const auto fresh = entry.make();
      Arguments arguments;
      fresh->Declare(arguments);
      EXPECT_NO_THROW(arguments.Parse(words)) << example.line;
    }
  }
}

TEST(Commands, HaveHelpThatFitsAHundredColumns) {
  setenv("NO_COLOR", "1", 1);
  const Console console;
  for (const CommandEntry& entry : Commands()) {
    EXPECT_LE(entry.summary.size(), 66U) << entry.summary;
    EXPECT_FALSE(entry.summary.ends_with('.')) << entry.summary;
    std::istringstream help(HelpOf(console, entry, Commands()));
    for (std::string line; std::getline(help, line);) EXPECT_LE(ColumnsOf(line), 100U) << line;
  }
  std::istringstream help(HelpOfAll(console, Commands()));
  for (std::string line; std::getline(help, line);) EXPECT_LE(ColumnsOf(line), 80U) << line;
}

TEST(Commands, UseEachOptionWithOneMeaning) {
  std::map<std::string, std::pair<std::string, std::string>> meanings;  // The names and the value of each name.
  for (const CommandEntry& entry : Commands()) {
    if (entry.family()) continue;
    const auto command = entry.make();
    Arguments arguments;
    command->Declare(arguments);
    for (const Argument& argument : arguments.all()) {
      if (argument.positional()) continue;
      std::istringstream names(argument.names);
      for (std::string name; std::getline(names, name, ',');) {
        const std::pair meaning(argument.names, argument.value);
        EXPECT_EQ(meanings.emplace(name, meaning).first->second, meaning) << entry.name << " " << name;
      }
    }
  }
  EXPECT_TRUE(meanings.contains("--json"));
}

TEST(Commands, OfAFamilyStandInItsGroup) {
  for (const CommandEntry& entry : Commands()) {
    if (!entry.IsInAny()) continue;
    const CommandEntry* family = FindCommand(entry.name.substr(0, entry.name.find(' ')));
    ASSERT_NE(family, nullptr) << entry.name;
    EXPECT_TRUE(entry.IsIn(*family)) << entry.name;
    EXPECT_EQ(entry.group, family->group) << entry.name;
  }
}

TEST(Commands, HaveManualPages) {
  const CommandEntry& echo = *FindCommand("echo");
  const std::string page = ManualOf("1.2", echo, Commands());
  EXPECT_THAT(page, testing::StartsWith(".TH \"HGROS\\-ECHO\" 1 \"\" \"hgros 1.2\""));
  EXPECT_THAT(page, HasSubstr("\n.TP\n\\fB\\-\\-once\\fR\n"));
  EXPECT_THAT(page, HasSubstr("\\(aqlevel == \"ERROR\"\\(aq"));
  EXPECT_THAT(ManualOf("1.2", *FindCommand("param"), Commands()), HasSubstr("\\fBhgros\\-param\\-get\\fR(1)"));
  EXPECT_THAT(ManualOfAll("1.2", Commands()), HasSubstr("\\fBhgros echo\\fR"));
}

}  // namespace
}  // namespace hgros::cli
