#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "commands/commands.hpp"
#include "commands/robots/robot_reading.hpp"
#include "export/compose_file.hpp"
#include "export/kubernetes_manifest.hpp"
#include "export/systemd_units.hpp"
#include "hgros/placement/robot_file.hpp"
#include "launch/host_networks.hpp"
#include "terminal/console.hpp"
#include "terminal/output_file.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

// What all exports have: the robot file, which is read as strictly as by hgros run, and where the result goes.
class Export : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"FILE", "", "The robot file", ValueKind::kFile, {}, true}, file_);
    arguments.Option("--set", "PATH=VALUE", set_, "Replace a value of the file, as `hgros run` does");
    arguments.Option("--path", "PATH", path_, "Where the file will be; otherwise where it is here", ValueKind::kFile);
    arguments.Option("--name", "ROBOT", name_, "Its name; otherwise that of the file");
    arguments.Option("--folder", "FOLDER", folder_, "Write files into this folder; otherwise to standard output",
                     ValueKind::kFile);
    arguments.Flag("--force", force_, "Replace files in the folder that differ");
    DeclareOwn(arguments);
  }
  int Run(Surroundings& surroundings) override;

 protected:
  virtual void DeclareOwn(Arguments& arguments) = 0;
  [[nodiscard]] virtual std::vector<ExportedFile> Write(const ExportedRobot& exported) const = 0;
  // Throws Error if it cannot be exported because of its hosts.
  virtual void CheckHosts(const RobotFile& robot) const = 0;

  std::string host_;

 private:
  void WriteInto(Console& console, const std::vector<ExportedFile>& files) const;

  std::string file_;
  std::vector<std::string> set_;
  std::string name_;
  std::string path_;
  std::string folder_;
  bool force_ = false;
};

std::string ContentOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// All or none: nothing is written if one of them is in the way.
void Export::WriteInto(Console& console, const std::vector<ExportedFile>& files) const {
  std::error_code fault;
  std::filesystem::create_directories(folder_, fault);
  if (!std::filesystem::is_directory(folder_)) {
    throw Error("The folder " + folder_ + " cannot be made: " + fault.message() + ".");
  }
  const std::filesystem::path folder = folder_;
  for (const ExportedFile& one : files) {
    const std::filesystem::path file = folder / one.name;
    if (force_ || !std::filesystem::exists(std::filesystem::symlink_status(file))) continue;
    if (ContentOf(file) != one.text) {
      throw Error("The file " + file.string() + " is there already, with another text.", {},
                  "Name another folder, or replace it with --force.");
    }
  }
  for (const ExportedFile& one : files) {
    const std::string file = (folder / one.name).string();
    WriteTo(console, file, one.text);
    console.Line(console.interactive() ? Visible(file) : file);
  }
}

int Export::Run(Surroundings& surroundings) {
  // A service does not have the variables of this shell.
  std::map<std::string, std::string> variables;
  RobotFileOptions options{.read_key_files = false, .host = host_};
  options.variables = [&](const std::string& name) {
    const std::optional<std::string> value = yaml::EnvironmentVariable(name);
    if (value) variables[name] = *value;
    return value;
  };
  const RobotFile robot = ReadRobot(surroundings.console, file_, WithSet(set_, options));
  CheckHosts(robot);
  for (const char* name : {"HGROS_DOMAIN", "HGROS_COMPONENT_PATH"}) {
    if (const auto value = yaml::EnvironmentVariable(name)) variables[name] = *value;
  }
  const std::filesystem::path file = std::filesystem::absolute(path_.empty() ? file_ : path_).lexically_normal();
  const std::string name = name_.empty() ? std::filesystem::path(file_).stem().string() : name_;
  const std::vector<ExportedFile> files = Write({PartOfHost(robot, host_, {}), name, host_, file, variables, set_});
  if (!folder_.empty()) {
    WriteInto(surroundings.console, files);
    return kDone;
  }
  std::string text;
  for (const ExportedFile& one : files) {
    if (files.size() > 1) text += (text.empty() ? "" : "\n") + ("# --- " + one.name + "\n");
    text += one.text;
  }
  WriteTo(surroundings.console, {}, text);
  return kDone;
}

class ExportSystemd final : public Export {
 public:
  [[nodiscard]] std::string Description() const override {
    return "Writes a service for each process and program of a robot file, and a target that starts and stops them "
           "together. systemd learns when a process runs, and starts it again when it fails or hangs. The units name "
           "the file by its absolute path: what it says about components counts at each start, the rest when it is "
           "exported again. Variables that the file uses become part of the units. docs/deployment.md has the steps.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros export systemd robot.yaml --folder ~/.config/systemd/user", "Writes units for systemctl --user."},
            {"hgros export systemd robot.yaml --user robot --folder units", "Writes units of the system."}};
  }

 protected:
  void DeclareOwn(Arguments& arguments) override {
    arguments.Option("--host", "HOST", host_, "Only the processes and programs of this host of the file");
    arguments.Option("--user", "USER", options_.user,
                     "Units of the system, which run as this user; otherwise a user's own");
    arguments.Option("--hgros", "PATH", options_.command, "Where hgros is on the robot; otherwise this program",
                     ValueKind::kFile);
  }
  [[nodiscard]] std::vector<ExportedFile> Write(const ExportedRobot& exported) const override;
  void CheckHosts(const RobotFile& robot) const override {
    RequireHost(robot, host_);
    for (const RobotProgram& one : robot.programs) {
      if (robot.hosts.empty() || !one.declares()) continue;
      throw Error(
          "Only `hgros run` tells \"" + one.name + "\" how it reaches the other hosts.", one.at.ToString(),
          "Leave out what it publishes, subscribes to, serves and calls, and give it a configuration of its own.");
    }
    if (!host_.empty()) return;
    const auto refuse_far = [](const RobotUnit& one) {
      if (one.host.empty()) return;
      throw Error("\"" + one.name + "\" runs on the host \"" + one.host + "\".", {},
                  "Export the part of each host with --host.");
    };
    for (const RobotProcess& one : robot.processes) refuse_far(one);
    for (const RobotProgram& one : robot.programs) refuse_far(one);
  }

 private:
  SystemdOptions options_;
};

// As systemd has it in its strict mode.
bool IsUserName(const std::string& name) {
  const auto lower = [](char it) { return it == '_' || (it >= 'a' && it <= 'z') || (it >= 'A' && it <= 'Z'); };
  const auto digit = [](char it) { return it >= '0' && it <= '9'; };
  return name.size() <= 31 && lower(name.front()) &&
         std::ranges::all_of(name, [&](char it) { return lower(it) || digit(it) || it == '-'; });
}

std::vector<ExportedFile> ExportSystemd::Write(const ExportedRobot& exported) const {
  if (!options_.user.empty() && !IsUserName(options_.user)) {
    throw UsageError("\"" + options_.user + "\" cannot be the name of a user. Write one as useradd takes it.");
  }
  SystemdOptions options = options_;
  if (options.command.empty()) options.command = std::filesystem::read_symlink("/proc/self/exe").string();
  // systemd takes no quotes and no backslashes here.
  if (!options.command.starts_with('/') || Visible(options.command) != options.command ||
      options.command.find_first_of("\"'\\$%") != std::string::npos) {
    throw UsageError(
        "The program \"" + options.command +
        "\" cannot be started by systemd. Give --hgros an absolute path without quotes, $, % and backslashes.");
  }
  return SystemdUnits(exported, options);
}

// Exports for engines that run containers.
class ExportContainers : public Export {
 protected:
  void DeclareOwn(Arguments& arguments) override {
    arguments.Option("--image", "IMAGE", options_.image, "The image, with hgros, the robot file and its components");
    arguments.Option("--hgros", "PATH", options_.command, "Where hgros is in the image; otherwise in its PATH",
                     ValueKind::kFile);
  }
  void CheckHosts(const RobotFile& robot) const override;
  [[nodiscard]] std::vector<ExportedFile> Write(const ExportedRobot& exported) const override {
    if (options_.image.empty()) throw UsageError("Give the image of the containers: --image IMAGE.");
    return {WriteFile(exported, options_)};
  }
  [[nodiscard]] virtual ExportedFile WriteFile(const ExportedRobot& exported,
                                               const ContainerOptions& options) const = 0;

 private:
  ContainerOptions options_;
};

void ExportContainers::CheckHosts(const RobotFile& robot) const {
  const auto refuse = [](const RobotUnit& unit) {
    if (unit.host.empty()) return;
    throw Error(
        "\"" + unit.name + "\" runs on the host \"" + unit.host + "\", but containers have no addresses of hosts.",
        unit.at.ToString(), "Export a file without hosts, which the file with hosts may include.");
  };
  std::ranges::for_each(robot.processes, refuse);
  std::ranges::for_each(robot.programs, refuse);
}

class ExportCompose final : public ExportContainers {
 public:
  [[nodiscard]] std::string Description() const override {
    return "Writes a service of Docker Compose for each process and program of a robot file. The services share a "
           "network of their own, so a host can run many robots. The image has hgros, the robot file at the same path, "
           "and its components. docs/deployment.md says what each key of the robot file becomes.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros export compose robot.yaml --image robot:1 > compose.yaml", "Writes a file for docker compose up."},
            {"hgros export compose robot.yaml --image robot:1 --path /robot/robot.yaml --folder out",
             "The image has the robot file at another path."}};
  }

 protected:
  [[nodiscard]] ExportedFile WriteFile(const ExportedRobot& exported, const ContainerOptions& options) const override {
    return ComposeFile(exported, options);
  }
};

class ExportKubernetes final : public ExportContainers {
 public:
  [[nodiscard]] std::string Description() const override {
    return "Writes a robot file as a pod of Kubernetes, with a container for each process and program: a Job, or a "
           "Deployment if something is always started again. The image has hgros, the robot file at the same path, and "
           "its components. docs/deployment.md says what each key of the robot file becomes.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros export kubernetes robot.yaml --image robot:1 | kubectl apply -f -", "Starts a robot in a cluster."},
            {"hgros export kubernetes robot.yaml --image robot:1 --name robot7 --folder out",
             "Writes a robot of another name into a folder."}};
  }

 protected:
  [[nodiscard]] ExportedFile WriteFile(const ExportedRobot& exported, const ContainerOptions& options) const override {
    return KubernetesManifest(exported, options);
  }
};

}  // namespace

std::unique_ptr<Command> MakeExportSystemd() { return std::make_unique<ExportSystemd>(); }
std::unique_ptr<Command> MakeExportKubernetes() { return std::make_unique<ExportKubernetes>(); }
std::unique_ptr<Command> MakeExportCompose() { return std::make_unique<ExportCompose>(); }

}  // namespace hgros::cli
