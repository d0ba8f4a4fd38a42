#include "export/unit_text.hpp"

#include <gtest/gtest.h>

namespace hgros::cli {
namespace {

TEST(UnitText, NamesOfUnitsAreEscapedAsSystemdDoes) {
  EXPECT_EQ(EscapedUnitName("slam_2"), "slam_2");
  EXPECT_EQ(EscapedUnitName("front-left lidar"), "front\\x2dleft\\x20lidar");
  EXPECT_EQ(EscapedUnitName(".hidden.name"), "\\x2ehidden.name");
  EXPECT_EQ(EscapedUnitName("\xc3\xa9"), "\\xc3\\xa9");
}

TEST(UnitText, NamesOfRobotsKeepHyphensButNoUnitHasTwoMeanings) {
  EXPECT_EQ(EscapedRobotName("my-robot"), "my-robot");
  EXPECT_EQ(EscapedRobotName("my robot-2"), "my\\x20robot-2");
  EXPECT_EQ(EscapedRobotName("-a-"), "\\x2da\\x2d");
  EXPECT_EQ(EscapedRobotName("back-end"), "back\\x2dend") << "back-end.target ends the robot named back.";
  EXPECT_NE(EscapedRobotName("a-b") + "-" + EscapedUnitName("c"), EscapedRobotName("a") + "-" + EscapedUnitName("b-c"));
}

TEST(UnitText, WordsAreQuotedIfNeedBe) {
  EXPECT_EQ(UnitWord("A=b/c-1"), "A=b/c-1");
  EXPECT_EQ(UnitWord("A=two words"), "\"A=two words\"");
  EXPECT_EQ(UnitWord("100%"), "100%%");
  EXPECT_EQ(UnitWord("a\"b\\c"), "\"a\\\"b\\\\c\"");
  EXPECT_EQ(UnitWord("a\nb"), "\"a\\x0ab\"");
  EXPECT_EQ(UnitWord(""), "\"\"");
}

TEST(UnitText, CommandsExpandNothing) { EXPECT_EQ(CommandLine({"echo", "$HOME", ";", "%h"}), "echo $$HOME \";\" %%h"); }

TEST(UnitText, SentencesStayOnTheirLine) {
  EXPECT_EQ(UnitSentence("50 %"), "50 %%");
  EXPECT_EQ(UnitSentence("a\\"), "a\\.");
  EXPECT_EQ(UnitSentence("a\nb").find('\n'), std::string::npos);
}

}  // namespace
}  // namespace hgros::cli
