#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hgros/command_run.hpp"

namespace hgros::cli {

/// A run of each command of this version, in all its forms, for a robot with Everything: channel "status",
/// service "ask", parameters of "robot" with "speed", frames "map" and "base". Those that would run forever have a
/// --timeout. A command without words here is a failure of the test.
[[nodiscard]] std::vector<std::vector<std::string>> RunsOfEveryCommand(const std::string& timeout = "3",
                                                                       bool with_json = true);

/// All of them at the same time.
struct FinishedRun {
  std::vector<std::string> words;
  int status = -1;  ///< As CommandRun::Wait().
  std::string out;
  std::string err;
};
[[nodiscard]] std::vector<std::unique_ptr<CommandRun>> Start(const std::vector<std::vector<std::string>>& runs,
                                                             const std::map<std::string, std::string>& environment);
[[nodiscard]] std::vector<FinishedRun> Finish(const std::vector<std::vector<std::string>>& runs,
                                              std::vector<std::unique_ptr<CommandRun>> started);

/// Both, with a few at once.
[[nodiscard]] std::vector<FinishedRun> RunAll(const std::vector<std::vector<std::string>>& runs,
                                              const std::map<std::string, std::string>& environment);

/// Expects that it has ended by itself, and has said why if it was in vain.
void ExpectGoodEnd(const FinishedRun& run);

}  // namespace hgros::cli
