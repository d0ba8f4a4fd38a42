#include "arguments/completion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "commands/commands.hpp"

namespace hgros::cli {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;

std::vector<std::string> WordsOf(const Completion& completion) {
  std::vector<std::string> words;
  for (const Completion::Word& word : completion.words) words.push_back(word.word);
  return words;
}

Completion Complete(const std::vector<std::string>& words) { return CompletionOf(words, Commands()); }

TEST(Completion, KnowsCommandsAndThoseOfAFamily) {
  const std::vector<std::string> all = WordsOf(Complete({""}));
  EXPECT_THAT(all, Contains("echo"));
  EXPECT_THAT(all, Contains("param"));
  EXPECT_THAT(all, Not(Contains("param get")));
  EXPECT_THAT(all, Not(Contains("__complete")));
  EXPECT_THAT(WordsOf(Complete({"param", "ge"})), ElementsAre("get"));
  EXPECT_THAT(WordsOf(Complete({"help", "tf", "tr"})), ElementsAre("tree"));
  EXPECT_THAT(WordsOf(Complete({"nothing", ""})), IsEmpty());
}

TEST(Completion, OffersOptionsThatAreNotThereYet) {
  EXPECT_THAT(WordsOf(Complete({"list", "--js"})), ElementsAre("--json"));
  EXPECT_THAT(WordsOf(Complete({"list", "--json", "--js"})), IsEmpty());
  EXPECT_THAT(WordsOf(Complete({"echo", "scan", "--field", "x", "--fie"})), ElementsAre("--field"));
  EXPECT_THAT(WordsOf(Complete({"--ver"})), ElementsAre("--version"));
}

TEST(Completion, KnowsWhatAValueNames) {
  EXPECT_THAT(WordsOf(Complete({"list", "no"})), ElementsAre("nodes"));
  EXPECT_EQ(Complete({"echo", "sc"}).kind, ValueKind::kChannel);
  EXPECT_EQ(Complete({"echo", "--once", "a", "b"}).kind, ValueKind::kChannel);
  EXPECT_EQ(Complete({"param", "get", ""}).kind, ValueKind::kParamSession);
  EXPECT_EQ(Complete({"param", "get", "robot", ""}).kind, ValueKind::kParam);
  EXPECT_EQ(Complete({"param", "get", "robot", "x", ""}).kind, ValueKind::kText);
  EXPECT_EQ(Complete({"tf", "echo", "--rate", "5", "map", ""}).kind, ValueKind::kFrame);
  EXPECT_EQ(Complete({"tf", "echo", "--rate", ""}).kind, ValueKind::kText);
  EXPECT_EQ(Complete({"list", "--config", ""}).kind, ValueKind::kFile);
  EXPECT_EQ(Complete({"list", "--config=a"}).kind, ValueKind::kFile);
  EXPECT_EQ(Complete({"list", "--config=a"}).typed, "a");
  EXPECT_EQ(Complete({"list", "--config=a"}).before, "--config=");
}

TEST(Completion, KeepsTheOptionsBeforeIt) {
  const Completion completion = Complete({"echo", "--domain", "lab", "--connect=tcp://a:1", "scan", "o"});
  EXPECT_THAT(completion.options, ElementsAre("--domain", "lab", "--connect", "tcp://a:1"));
  EXPECT_THAT(completion.given, ElementsAre("scan"));
  EXPECT_EQ(completion.typed, "o");
}

}  // namespace
}  // namespace hgros::cli
