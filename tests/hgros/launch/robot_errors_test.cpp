// Each sentence that the reader of robot files and the check of their components say, as the user gets it.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "hgros/command_run.hpp"
#include "hgros/launch/robot_folder.hpp"
#include "support/path.hpp"

namespace hgros::cli {
namespace {

struct ErrorCase {
  std::string name;
  std::string words;  // Behind it: the command that is asked, without the file.
  std::string text;   // Of the robot file.
  std::string said;
};

// The cases of robot_errors.txt: "== NAME | COMMAND", the file, and what is said, behind "-> ".
std::vector<ErrorCase> Cases() {
  std::vector<ErrorCase> cases;
  std::ifstream file(test::Path("robot_errors"));
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("== ")) {
      const std::size_t bar = std::min(line.find(" | "), line.size());
      const bool asks = bar < line.size();
      cases.push_back({line.substr(3, bar - 3), asks ? line.substr(bar + 3) : "check", {}, {}});
    } else if (line.starts_with("-> ")) {
      cases.back().said += line.substr(3) + "\n";
    } else if (!cases.empty() && cases.back().said.empty()) {
      cases.back().text += line + "\n";
    }
  }
  return cases;
}

// Without the folders of this machine.
std::string Said(const ErrorCase& one) {
  const RobotFolder robot(one.text);
  std::istringstream in(one.words);
  std::vector<std::string> words(std::istream_iterator<std::string>(in), {});
  words.insert(words.begin() + 1, robot.file());
  const CommandEnd end = robot.Ask(words);
  EXPECT_NE(end.status, 0) << one.name;
  const std::string said = std::regex_replace(end.out + end.err, std::regex(robot.path("").string()), "");
  return std::regex_replace(said, std::regex("Looked in: .*"), "Looked in: FOLDERS");
}

TEST(RobotErrors, SayWhatIsWrongAndWhereAndHowToMendIt) {
  const std::vector<ErrorCase> cases = Cases();
  std::string all;
  for (const ErrorCase& one : cases) all += one.said;
  EXPECT_GT(Times(all, "\n"), 140U);
  TwoAtATime(cases.size(), [&](std::size_t i) { EXPECT_EQ(Said(cases[i]), cases[i].said) << cases[i].name; });
}

}  // namespace
}  // namespace hgros::cli
