#pragma once

#include <gtest/gtest.h>
#include <sys/types.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "hgros/command_run.hpp"
#include "hgros/transport/curve_key_pair.hpp"
#include "support/await.hpp"
#include "support/path.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::cli {

/// A robot file in a folder of its own, and its domain.
class RobotFolder {
 public:
  explicit RobotFolder(const std::string& text, std::string manifests = test::Path("words_manifests"))
      : manifests_(std::move(manifests)) {
    Write("robot.yaml", text);
  }

  [[nodiscard]] std::string file() const { return path("robot.yaml"); }
  [[nodiscard]] std::filesystem::path path(const std::string& name) const { return folder_ / name; }
  [[nodiscard]] std::string domain() const { return folder_.path().filename(); }
  [[nodiscard]] std::map<std::string, std::string> environment() const {
    return {{"HGROS_COMPONENT_PATH", manifests_},
            {"HGROS_DOMAIN", domain()},
            {"FOLDER", folder_.path()},
            {"XDG_STATE_HOME", path("state")}};
  }
  std::string Write(const std::string& name, const std::string& text) const { return folder_.Write(name, text); }
  [[nodiscard]] std::string Read(const std::string& name) const { return folder_.Read(name); }
  [[nodiscard]] std::vector<std::string> Arguments(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"run", file()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  [[nodiscard]] CommandEnd Run(const std::vector<std::string>& more = {}) const { return Ask(Arguments(more)); }
  [[nodiscard]] CommandEnd Ask(const std::vector<std::string>& words) const { return RunToEnd(words, environment()); }
  CommandEnd AskUntil(const std::vector<std::string>& words, const testing::Matcher<const CommandEnd&>& ends) const {
    return RunUntil(words, environment(), ends);
  }
  /// What sessions of its domain have left where sessions find each other.
  [[nodiscard]] std::vector<std::string> FilesLeft() const {
    const std::string user = std::to_string(geteuid());
    const char* const runtime = std::getenv("XDG_RUNTIME_DIR");
    const std::vector<std::string> places{(runtime == nullptr ? "/run/user/" + user : std::string(runtime)) + "/hgros",
                                          "/tmp/hgros-" + user};
    std::vector<std::string> left;
    for (const std::string& place : places) {
      std::error_code none;
      for (const auto& file : std::filesystem::directory_iterator(place + "/" + domain(), none)) {
        left.push_back(file.path());
      }
    }
    return left;
  }

 private:
  const std::string manifests_;  // The folder of the components.
  const test::ScratchFolder folder_;
};

/// How often a text has the other one.
inline std::size_t Times(const std::string& text, const std::string& part) {
  std::size_t times = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++times;
  return times;
}

/// A robot that `hgros run` runs. It is ended by SIGINT with this object, unless it has ended before.
class RunningRobot : public RobotFolder, public CommandRun {
 public:
  explicit RunningRobot(const std::string& text, const std::string& manifests = test::Path("words_manifests"))
      : RobotFolder(text, manifests), CommandRun(Arguments(), environment()) {}
  ~RunningRobot() {
    if (!ended()) End();
  }

  /// Waits until the output contains `text` as often.
  [[nodiscard]] bool Prints(const std::string& text, std::size_t times = 1) const {
    return test::Await([&] { return Times(out(), text) >= times; });
  }
};

/// Two hosts with keys: "desk", where the robot is at home, and "base".
class RobotWithKeys : public RobotFolder {
 public:
  /// ssh connects to 10.198.0.2.
  explicit RobotWithKeys(const std::string& desk_address = "10.198.0.1", const std::string& base_address = "10.198.0.2")
      : RobotWithKeys(desk_address, GenerateCurveKeyPair(), base_address, GenerateCurveKeyPair()) {}
  /// Before, its host cannot read it.
  void WriteKey(const std::string& host) const {
    Write(host + ".key", host == "desk" ? desk_ : base_);
    std::filesystem::permissions(path(host + ".key"), std::filesystem::perms::owner_read);
  }

 private:
  RobotWithKeys(const std::string& desk_address, const CurveKeyPair& desk, const std::string& base_address,
                const CurveKeyPair& base)
      : RobotFolder("hosts:\n  desk: {address: \"" + desk_address + "\", home: true, key: \"" + desk.public_key +
                    "\", secret_key_file: \"${FOLDER}/desk.key\"}\n  base: {address: \"" + base_address +
                    "\", ssh: 10.198.0.2, key: \"" + base.public_key +
                    "\", secret_key_file: \"${FOLDER}/base.key\"}\n"
                    "discovery: {local: false}\n"
                    "components: {numbers: {type: relay/Numbers}, one: {type: relay/Checker}}\n"
                    "processes: {p: {components: [numbers], host: base}}\n"),
        desk_(desk.secret_key),
        base_(base.secret_key) {}

  const std::string desk_;
  const std::string base_;
};

/// Whether the process still runs; one that waits for its parent does not.
inline bool Runs(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string stat((std::istreambuf_iterator<char>(file)), {});
  return !stat.empty() && stat.find(") Z ") == std::string::npos;
}

/// The last column of a table.
inline std::vector<pid_t> PidsIn(const std::string& out) {
  std::vector<pid_t> pids;
  const std::regex row(R"(\n[^\n]* (\d+)(?=\n))");
  for (std::sregex_iterator at(out.begin(), out.end(), row), end; at != end; ++at) pids.push_back(std::stoi((*at)[1]));
  return pids;
}

}  // namespace hgros::cli
