#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hgros/command_run.hpp"

namespace hgros::cli {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(HgrosHelp, ListsAllCommandsAndEndsWithZero) {
  const CommandEnd end = RunToEnd({"help"});
  EXPECT_EQ(end.status, 0);
  EXPECT_THAT(end.out, HasSubstr("  list "));
  EXPECT_THAT(end.out, HasSubstr("  echo "));
  EXPECT_EQ(end.err, "");
}

TEST(HgrosHelp, ExplainsACommandWithTwoExamples) {
  for (const char* command : {"list", "info", "echo", "hz", "bw", "delay", "schema", "graph", "doctor", "pub", "call",
                              "help", "completion"}) {
    const CommandEnd end = RunToEnd({"help", command});
    EXPECT_EQ(end.status, 0);
    const std::string examples = end.out.substr(end.out.find("Examples:"));
    EXPECT_THAT(examples, HasSubstr("  hgros " + std::string(command))) << command;
    EXPECT_GE(LinesOf(examples).size(), 5U) << command;
    EXPECT_EQ(RunToEnd({command, "--help"}).out, end.out);
  }
}

TEST(HgrosHelp, NamesTheNearestCommandAndOption) {
  const CommandEnd command = RunToEnd({"lst"});
  EXPECT_EQ(command.status, 2);
  EXPECT_EQ(command.err, "hgros: There is no command \"lst\". Did you mean list?\n");
  const CommandEnd option = RunToEnd({"list", "--domian", "x"});
  EXPECT_EQ(option.status, 2);
  EXPECT_EQ(option.err, "hgros: --domian is not an option. Did you mean --domain?\n");
}

TEST(HgrosHelp, ExplainsACommandOfAFamily) {
  const CommandEnd end = RunToEnd({"help", "param", "get"});
  EXPECT_EQ(end.status, 0);
  EXPECT_THAT(end.out, HasSubstr("Usage: hgros param get [SESSION] [PATH] [OPTIONS]\n"));
  EXPECT_EQ(RunToEnd({"param", "get", "--help"}).out, end.out);
  EXPECT_EQ(RunToEnd({"param", "--help"}).status, 0);
  EXPECT_EQ(RunToEnd({"help", "list", "all"}).err, "hgros: \"all\" is one argument too many.\n");
}

TEST(HgrosHelp, TakesListsAndNegativeNumbersAsValues) {
  EXPECT_THAT(RunToEnd({"list", "[a,b]"}).err, HasSubstr("WHAT: \"[a,b]\" is not one of:"));
  EXPECT_THAT(RunToEnd({"echo", "scan", "--rate", "-1.5"}).err, HasSubstr("\"-1.5\" is not a number above zero."));
  EXPECT_EQ(RunToEnd({"list", "nodes", "-1"}).err, "hgros: -1 is not an option.\n");
}

TEST(HgrosHelp, RefusesValuesThatAreNoNumbers) {
  EXPECT_THAT(RunToEnd({"echo", "scan", "-n", "0"}).err, HasSubstr("\"0\" is not a whole number above zero."));
  EXPECT_THAT(RunToEnd({"echo", "scan", "--rate", "fast"}).err, HasSubstr("\"fast\" is not a number above zero."));
  const CommandEnd none = RunToEnd({"echo"});
  EXPECT_EQ(none.status, 2);
  EXPECT_THAT(none.err, StartsWith("hgros: CHANNEL is missing."));
}

}  // namespace
}  // namespace hgros::cli
