#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/base/export.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/component/components.hpp"
#include "hgros/config/config.hpp"
#include "hgros/params/param_sources.hpp"
#include "hgros/yaml/document.hpp"

namespace hgros {

/// Whether a process or program that has ended is started again.
enum class RestartPolicy : std::uint8_t {
  kNever,
  kOnFailure,  ///< If its exit code was not 0, or a signal ended it.
  kAlways,
};

/// When a component is ended and constructed again, alone in its process, while the others run on.
enum class ComponentRestart : std::uint8_t {
  kNever,
  kOnFailure,    ///< It has failed.
  kOnException,  ///< It has failed, or one of its callbacks threw.
  kOnDeadline,   ///< The same, or one of its callbacks took longer than its deadline.
};

/// A computer of the robot.
struct RobotHost {
  std::string name;
  std::string address;   ///< At which the other hosts reach it.
  int port = 0;          ///< Of its first process that publishes for other hosts; the next one has the next port.
  std::string key = {};  ///< Its public CURVE key; empty: no encryption.
  std::string secret_key_file = {};  ///< On that host.
  bool home = false;                 ///< `hgros run` is started there.
  std::string ssh = {};              ///< What ssh is told to connect to; empty: the address.
  std::string hgros = "hgros";       ///< The command there, as the login shell runs it.
  FilePosition at = {};              ///< Of its name.
};

/// What runs in its own process.
struct RobotUnit {
  std::string name;
  std::string host;                        ///< Where it runs; empty: where `hgros run` is started.
  std::map<std::string, std::string> env;  ///< Variables of the environment, in addition to those of the starter.
  std::vector<int> cpus;                   ///< Where its threads may run; empty: everywhere.
  int nice = 0;                            ///< -20 to 19; fewer is more urgent.
  int priority = 0;                        ///< Of SCHED_FIFO for its threads, 1 to 99; 0: the normal scheduler.
  std::uint64_t memory_bytes = 0;          ///< What it may use, with the processes that it starts; 0: no limit.
  RestartPolicy restart = RestartPolicy::kNever;
  bool essential = false;  ///< The robot ends with it.
  FilePosition at;         ///< Of its name.
};

struct RobotComponent {
  ComponentSetup setup;
  std::string process;     ///< Where it runs.
  bool essential = false;  ///< The robot ends when it finishes or fails.
  ComponentRestart restart = ComponentRestart::kNever;
  Duration checkpoint{0};  ///< How often its state is saved for a restart; 0: never.
  FilePosition at;         ///< Of its name.
};

/// A session with components. The session has the name of the process.
struct RobotProcess : RobotUnit {
  std::vector<std::string> components;  ///< In the order in which they are constructed; the last one ends first.
  Config config;                        ///< The sections of the whole robot, and on top of them those of the process.
};

/// A program in any language.
struct RobotProgram : RobotUnit {
  std::vector<std::string> command;  ///< The program, looked for in PATH, and its arguments.
  /// What it exchanges, as far as the file says: channels and services. Only that passes between hosts.
  std::vector<std::string> publishes = {};
  std::vector<std::string> subscribes = {};
  std::vector<std::string> serves = {};
  std::vector<std::string> calls = {};

  [[nodiscard]] bool declares() const {
    return !publishes.empty() || !subscribes.empty() || !serves.empty() || !calls.empty();
  }
};

struct RobotFileOptions {
  yaml::Variables variables = yaml::EnvironmentVariable;  ///< For ${NAME}.
  /// Values that replace those of the file. A path begins with a component, or with a key at the top of the file:
  /// "mapper.params.cell_size_m", "processes.front.nice".
  std::vector<ParamOverride> overrides = {};
  bool read_key_files = true;  ///< As in ConfigCheckOptions. Those of other hosts are never opened.
  std::string host = {};       ///< Which host this is; empty: where `hgros run` is started.
};

struct CheckedRobotFile;

/// What runs on a robot, and where. docs/robot-file.md describes the file.
struct HGROS_EXPORT RobotFile {
  std::vector<RobotComponent> components;  ///< In the order of the file.
  std::vector<RobotProcess> processes;     ///< In the order in which they start; the last one ends first.
  std::vector<RobotProgram> programs;      ///< They start after the processes.
  std::vector<RobotHost> hosts;            ///< In the order of the file.

  /// Reads a file and what it includes. Throws ConfigError for the first fault.
  [[nodiscard]] static RobotFile Load(const std::filesystem::path& file, const RobotFileOptions& options = {});
  /// The same, but does not stop at the first fault. Does not throw ConfigError.
  [[nodiscard]] static CheckedRobotFile Check(const std::filesystem::path& file, const RobotFileOptions& options = {});
  /// The file with what it includes, its variables and the overrides in place, and the same as above from there.
  [[nodiscard]] static yaml::Document Assemble(const std::filesystem::path& file, const RobotFileOptions& options = {});
  [[nodiscard]] static CheckedRobotFile Check(const yaml::Document& document, const RobotFileOptions& options = {});
  /// Whether a file is a robot file: it has a section that only those have, a key similar to "components", or includes
  /// a file that cannot be read. Keys in `sections_of_program` do not count. If the file is not YAML, its lines are
  /// looked at. False if it cannot be read.
  [[nodiscard]] static bool Is(const std::filesystem::path& file,
                               const std::vector<std::string>& sections_of_program = {});

  /// From now on the component runs in that process. There are both.
  void Place(std::string_view component, std::string_view process);

  /// Null if there is none of that name.
  [[nodiscard]] const RobotComponent* FindComponent(std::string_view name) const;
  [[nodiscard]] const RobotProcess* FindProcess(std::string_view name) const;
  /// As RobotUnit::host names it: the empty name is that of the host where `hgros run` is started.
  [[nodiscard]] const RobotHost* FindHost(std::string_view name) const;
};

/// A robot file, and everything that is wrong with it.
struct CheckedRobotFile {
  RobotFile robot;                  ///< Without what is wrong.
  std::vector<ConfigError> faults;  ///< Empty: RobotFile::Load() accepts the file.
};

}  // namespace hgros
