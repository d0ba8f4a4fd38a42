#pragma once

#include <stdlib.h>
#include <sys/types.h>
#include <unistd.h>

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
#include "support/path.hpp"

namespace hgros::cli {

/// A robot file in a folder of its own, and its domain.
class RobotFolder {
 public:
  explicit RobotFolder(const std::string& text, std::string manifests = test::Path("words_manifests"))
      : manifests_(std::move(manifests)) {
    std::string name = (std::filesystem::temp_directory_path() / "hgros_run_XXXXXX").string();
    folder_ = mkdtemp(name.data());
    std::ofstream(file()) << text;
  }
  ~RobotFolder() { std::filesystem::remove_all(folder_); }
  RobotFolder(const RobotFolder&) = delete;
  RobotFolder& operator=(const RobotFolder&) = delete;

  [[nodiscard]] std::string file() const { return folder_ / "robot.yaml"; }
  [[nodiscard]] std::filesystem::path path(const std::string& name) const { return folder_ / name; }
  [[nodiscard]] std::map<std::string, std::string> environment() const {
    return {{"HGROS_COMPONENT_PATH", manifests_},
            {"HGROS_DOMAIN", folder_.filename().string()},
            {"FOLDER", folder_.string()}};
  }
  [[nodiscard]] std::vector<std::string> Arguments(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"run", file()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  [[nodiscard]] CommandEnd Run(const std::vector<std::string>& more = {}) const {
    return RunToEnd(Arguments(more), environment());
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
      for (const auto& file : std::filesystem::directory_iterator(place + "/" + folder_.filename().string(), none)) {
        left.push_back(file.path());
      }
    }
    return left;
  }

 private:
  const std::string manifests_;  // The folder of the components.
  std::filesystem::path folder_;
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
