#include "hgros/every/every_command.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <map>

#include "commands/commands.hpp"

namespace hgros::cli {
namespace {

using Words = std::vector<std::string>;

// By the name of the command.
const std::multimap<std::string, Words>& WordsByCommand() {
  static const std::multimap<std::string, Words> words{
      {"list", {}},
      {"list", {"sessions"}},
      {"list", {"nodes"}},
      {"list", {"services"}},
      {"list", {"params"}},
      {"list", {"frames"}},
      {"list", {"--all"}},
      {"info", {"status"}},
      {"info", {"robot"}},
      {"info", {"hearing"}},
      {"info", {"ask"}},
      {"echo", {"status", "--once"}},
      {"echo", {"status", "--once", "--csv"}},
      {"hz", {"status", "--once"}},
      {"hz", {"status", "--once", "--receive"}},
      {"bw", {"status", "--once"}},
      {"bw", {"status", "--once", "--receive"}},
      {"delay", {"status", "--once"}},
      {"delay", {"status", "--once", "--receive"}},
      {"schema", {"foxglove.Log"}},
      {"schema", {"status"}},
      {"graph", {}},
      {"graph", {"--svg"}},
      {"graph", {"--dot"}},
      {"graph", {"--around", "hearing", "--depth", "3"}},
      {"top", {"--once"}},
      {"top", {"nodes", "--once"}},
      {"top", {"channels", "--once"}},
      {"tf tree", {}},
      {"tf echo", {"map", "base", "--once"}},
      {"tf watch", {}},
      {"tf svg", {}},
      {"doctor", {}},
      {"doctor", {"--verbose"}},
      {"path", {"timer/tick", "status"}},
      {"trace", {"--seconds", "1"}},
      {"pub", {"status", "{message: hello}", "--type", "foxglove.Log"}},
      {"call", {"ask", "{message: hello}", "--type", "foxglove.Log"}},
      {"param list", {}},
      {"param get", {"robot", "speed"}},
      {"param describe", {"robot", "speed"}},
      {"param watch", {"robot"}},
      {"param set", {"robot", "speed", "2"}},
      {"param save", {"robot"}},
      {"param load", {"robot", "/dev/null"}},
      {"control close", {"status"}},
      {"control open", {"status"}},
      {"control forbid", {"other"}},
      {"control allow", {"other"}},
      {"control log", {"info"}},
      {"control stop", {"--session", "nobody"}},
      {"check", {"/dev/null"}},
      {"check", {"--schema"}},
      {"check", {"--schema", "--robot-file"}},
      {"run", {"/dev/null"}},
      {"ps", {}},
      {"logs", {}},
      {"restart", {"mapper"}},
      {"move", {"mapper", "--to", "front"}},
      {"stop", {}},
      {"wait", {}},
      {"export systemd", {"robot.yaml"}},
      {"export compose", {"robot.yaml"}},
      {"export kubernetes", {"robot.yaml"}},
      {"components", {}},
      {"help", {"list"}},
      {"completion", {"bash"}},
      {"__complete", {"--", "echo", ""}},
      {"__complete", {"--", "param", "get", ""}},
      {"__man", {}},
      {"__hosted", {}},
  };
  return words;
}

bool HasOption(const CommandEntry& entry, const std::string& name) {
  Arguments arguments;
  const auto command = entry.make();
  command->Declare(arguments);
  return std::ranges::any_of(arguments.all(), [&](const Argument& one) { return one.names == name; });
}

}  // namespace

std::vector<Words> RunsOfEveryCommand(const std::string& timeout, bool with_json) {
  std::vector<Words> runs;
  for (const CommandEntry& entry : Commands()) {
    if (entry.family()) continue;
    const auto [begin, end] = WordsByCommand().equal_range(std::string(entry.name));
    EXPECT_NE(begin, end) << "Give this test words for the new command " << entry.name;
    for (auto one = begin; one != end; ++one) {
      Words run;
      std::string name(entry.name);
      if (const std::size_t space = name.find(' '); space != std::string::npos) {
        run = {name.substr(0, space), name.substr(space + 1)};
      } else {
        run = {name};
      }
      if (HasOption(entry, "--timeout")) {
        run.emplace_back("--timeout");
        run.push_back(timeout);
      }
      run.insert(run.end(), one->second.begin(), one->second.end());
      runs.push_back(run);
      const auto has = [&](const char* word) { return std::ranges::find(run, word) != run.end(); };
      if (!with_json || !HasOption(entry, "--json") || has("--svg") || has("--dot") || has("--csv")) continue;
      run.emplace_back("--json");
      runs.push_back(run);
    }
  }
  return runs;
}

std::vector<std::unique_ptr<CommandRun>> Start(const std::vector<Words>& runs,
                                               const std::map<std::string, std::string>& environment) {
  std::vector<std::unique_ptr<CommandRun>> started;
  for (const Words& words : runs) started.push_back(std::make_unique<CommandRun>(words, environment));
  return started;
}

std::vector<FinishedRun> Finish(const std::vector<Words>& runs, std::vector<std::unique_ptr<CommandRun>> started) {
  std::vector<FinishedRun> finished;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const int status = started[i]->Wait();
    finished.push_back({runs[i], status, started[i]->out(), started[i]->err()});
  }
  return finished;
}

std::vector<FinishedRun> RunAll(const std::vector<Words>& runs, const std::map<std::string, std::string>& environment) {
  constexpr std::size_t kAtOnce = 8;
  std::vector<FinishedRun> finished;
  for (std::size_t begin = 0; begin < runs.size(); begin += kAtOnce) {
    const auto from = runs.begin() + static_cast<std::ptrdiff_t>(begin);
    const std::vector<Words> part(from, from + static_cast<std::ptrdiff_t>(std::min(kAtOnce, runs.size() - begin)));
    std::ranges::move(Finish(part, Start(part, environment)), std::back_inserter(finished));
  }
  return finished;
}

void ExpectGoodEnd(const FinishedRun& run) {
  const std::string line = testing::PrintToString(run.words);
  EXPECT_THAT(run.status, testing::AnyOf(0, 1, 2, 3)) << line << " does not end by itself: " << run.out << run.err;
  // The doctor's findings are its output, and a shell that completes words wants no sentences.
  const bool says_why = !run.err.empty() || run.words.front() == "doctor" || run.words.front() == "__complete" ||
                        (run.status == 3 && !run.out.empty());
  EXPECT_TRUE(run.status == 0 || says_why) << line << " ends with " << run.status << " without a word.";
  for (const std::string& sentence : LinesOf(run.err)) {
    EXPECT_THAT(sentence, testing::StartsWith("hgros: ")) << line;
    EXPECT_THAT(sentence, testing::AnyOf(testing::EndsWith("."), testing::EndsWith("?"))) << line;
  }
}

}  // namespace hgros::cli
