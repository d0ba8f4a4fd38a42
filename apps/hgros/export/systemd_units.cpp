#include "export/systemd_units.hpp"

#include <algorithm>
#include <string_view>

#include "export/unit_text.hpp"
#include "hgros/base/error.hpp"
#include "hosting/service_process.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kMostUnitNameBytes = 255;

class UnitsWriter {
 public:
  UnitsWriter(const ExportedRobot& exported, const SystemdOptions& options);

  [[nodiscard]] std::vector<ExportedFile> Write() const;

 private:
  [[nodiscard]] std::string NameOf(std::string_view unit) const;
  [[nodiscard]] std::string TargetText() const;
  [[nodiscard]] std::string EndText() const;
  [[nodiscard]] std::string ProcessText(const RobotProcess& process) const;
  [[nodiscard]] std::string ProgramText(const RobotProgram& program) const;
  [[nodiscard]] std::string HeadOf(const RobotUnit& unit, const std::string& what, bool essential) const;
  [[nodiscard]] std::string SettingsOf(const RobotUnit& unit) const;
  [[nodiscard]] bool HasEssential() const;
  [[nodiscard]] bool OfSystem() const { return !options_.user.empty(); }

  const ExportedRobot& exported_;
  const SystemdOptions& options_;
  const std::string prefix_;
  const std::string target_ = prefix_ + ".target";
  const std::string end_ = prefix_ + "-end.target";
};

void CheckFolder(const std::string& folder) {
  const bool fits = Visible(folder) == folder && !folder.ends_with(' ') && !folder.ends_with('\\');
  if (fits) return;
  throw Error("The folder \"" + Visible(folder) + "\" cannot be the WorkingDirectory of a unit.", {},
              "Rename it: it must not have control characters, nor end with a space or a backslash.");
}

// systemd leaves out a variable that it does not accept, with no more than a warning.
void CheckVariable(const std::string& name, const std::string& value, const std::string& place) {
  const auto letter = [](char it) { return it == '_' || (it >= 'a' && it <= 'z') || (it >= 'A' && it <= 'Z'); };
  const auto digit = [](char it) { return it >= '0' && it <= '9'; };
  if (name.empty() || digit(name.front()) ||
      !std::ranges::all_of(name, [&](char it) { return letter(it) || digit(it); })) {
    throw Error("systemd accepts no variable \"" + Visible(name) + "\".", place,
                "Rename it: letters, digits and \"_\", with no digit first.");
  }
  const auto refused = [](char it) {
    return (static_cast<unsigned char>(it) < 0x20 && it != '\t' && it != '\n') || it == 0x7f;
  };
  if (std::ranges::any_of(value, refused) || ValidUtf8(value) != value) {
    throw Error("systemd does not accept the value of the variable " + name + ".", place,
                "Remove its control characters, and what is not UTF-8.");
  }
}

std::string TextOf(RestartPolicy policy) {
  switch (policy) {
    case RestartPolicy::kNever: return "no";
    case RestartPolicy::kOnFailure: return "on-failure";
    case RestartPolicy::kAlways: return "always";
  }
  return "no";
}

UnitsWriter::UnitsWriter(const ExportedRobot& exported, const SystemdOptions& options)
    : exported_(exported), options_(options), prefix_(EscapedRobotName(exported.name)) {
  CheckFolder(exported.file.parent_path().string());
  for (const auto& [name, value] : exported.variables) CheckVariable(name, value, {});
}

std::string UnitsWriter::NameOf(std::string_view unit) const {
  std::string name = prefix_ + "-" + EscapedUnitName(unit) + ".service";
  if (name.size() <= kMostUnitNameBytes) return name;
  throw Error("The name " + name + " is too long for a unit.", {}, "Use shorter names, or --name.");
}

bool UnitsWriter::HasEssential() const {
  const auto essential = [](const RobotUnit& unit) { return unit.essential; };
  return std::ranges::any_of(exported_.robot.processes, essential) ||
         std::ranges::any_of(exported_.robot.programs, essential) ||
         std::ranges::any_of(exported_.robot.components, &RobotComponent::essential);
}

std::vector<ExportedFile> UnitsWriter::Write() const {
  std::vector<ExportedFile> files{{target_, TargetText()}};
  if (HasEssential()) files.push_back({end_, EndText()});
  for (const RobotProcess* one : exported_.Processes()) files.push_back({NameOf(one->name), ProcessText(*one)});
  for (const RobotProgram& one : exported_.robot.programs) files.push_back({NameOf(one.name), ProgramText(one)});
  return files;
}

std::string UnitsWriter::TargetText() const {
  std::string text = "# Written by hgros export from " + UnitSentence(exported_.file.string()) +
                     "\n[Unit]\nDescription=" + UnitSentence("Robot " + exported_.name + ", all of it") + "\n";
  for (const RobotProcess* one : exported_.Processes()) text += "Wants=" + NameOf(one->name) + "\n";
  for (const RobotProgram& one : exported_.robot.programs) text += "Wants=" + NameOf(one.name) + "\n";
  return text + "\n[Install]\nWantedBy=" + (OfSystem() ? "multi-user.target" : "default.target") + "\n";
}

// Starting this target stops the robot, and starting the robot stops this target.
std::string UnitsWriter::EndText() const {
  return "# Started when something essential has ended.\n[Unit]\nDescription=" +
         UnitSentence("Robot " + exported_.name + " ends") + "\nConflicts=" + target_ + "\nRefuseManualStart=yes\n";
}

std::string UnitsWriter::HeadOf(const RobotUnit& unit, const std::string& what, bool essential) const {
  std::string text =
      "# Written by hgros export from " + UnitSentence(exported_.file.string()) +
      "\n[Unit]\nDescription=" + UnitSentence("Robot " + exported_.name + ": " + what + " " + unit.name) +
      "\nPartOf=" + target_ + "\n";
  if (essential) text += "OnFailure=" + end_ + "\nOnSuccess=" + end_ + "\n";
  // Five restarts within a minute, as hgros run has it.
  return text + "StartLimitIntervalSec=60\nStartLimitBurst=6\n";
}

// Of the section [Service].
std::string UnitsWriter::SettingsOf(const RobotUnit& unit) const {
  std::string text = "WorkingDirectory=" + UnitSentence(exported_.file.parent_path().string()) + "\n";
  if (OfSystem()) {
    // All robots of the user share the folder, in which their sessions find each other.
    const std::string folder = "hgros-" + options_.user;
    text += "User=" + options_.user + "\nRuntimeDirectory=" + folder +
            "\nRuntimeDirectoryMode=0700\nRuntimeDirectoryPreserve=yes\nEnvironment=XDG_RUNTIME_DIR=/run/" + folder +
            "\n";
  }
  for (const auto& [name, value] : unit.env) CheckVariable(name, value, unit.at.ToString());
  for (const auto& [name, value] : exported_.VariablesOf(unit))
    text += "Environment=" + UnitWord(name + "=" + value) + "\n";
  if (!unit.cpus.empty()) {
    text += "CPUAffinity=";
    for (const int cpu : unit.cpus) text += (text.ends_with('=') ? "" : " ") + std::to_string(cpu);
    text += "\n";
  }
  if (unit.nice != 0) text += "Nice=" + std::to_string(unit.nice) + "\n";
  if (unit.priority > 0) {
    text += "CPUSchedulingPolicy=fifo\nCPUSchedulingPriority=" + std::to_string(unit.priority) + "\n";
  }
  if (unit.memory_bytes > 0) text += "MemoryMax=" + std::to_string(unit.memory_bytes) + "\n";
  return text + "Restart=" + TextOf(unit.restart) + "\nRestartSec=100ms\nTimeoutStopSec=2s\n";
}

std::string UnitsWriter::ProcessText(const RobotProcess& process) const {
  const bool essential = exported_.HasEssentialComponent(process);
  std::string text = HeadOf(process, "process", essential || process.essential) +
                     "\n[Service]\nType=notify\nNotifyAccess=main\nWatchdogSec=10s\nExecStart=" +
                     CommandLine(exported_.CommandOf(process, options_.command)) + "\n" + SettingsOf(process) +
                     "KillMode=mixed\n";
  if (essential) {
    // It ends with one of these numbers when an essential component has ended, and then is not started again.
    const std::string finished = std::to_string(kEssentialFinished);
    text += "SuccessExitStatus=" + finished + "\nRestartPreventExitStatus=" + finished + " " +
            std::to_string(kEssentialFailed) + "\n";
  }
  text += "LimitNOFILE=4096\nLimitRTPRIO=99\nNoNewPrivileges=yes\nLockPersonality=yes\n";
  if (OfSystem()) text += "ProtectSystem=full\nProtectKernelModules=yes\nProtectControlGroups=yes\n";
  return text;
}

std::string UnitsWriter::ProgramText(const RobotProgram& program) const {
  // systemd has a search path of its own, and does not start every name: env looks in PATH.
  std::vector<std::string> command{"/usr/bin/env", "--"};
  command.insert(command.end(), program.command.begin(), program.command.end());
  if (program.command.front().find('=') != std::string::npos) {
    throw Error("The program \"" + Visible(program.command.front()) + "\" cannot be exported: its name has a \"=\".",
                program.at.ToString(), "Rename it, or write a script that starts it.");
  }
  std::string text = HeadOf(program, "program", program.essential);
  for (const RobotProcess* one : exported_.Processes()) text += "After=" + NameOf(one->name) + "\n";
  return text + "\n[Service]\nType=exec\nExecStart=" + CommandLine(command) + "\n" + SettingsOf(program);
}

}  // namespace

std::vector<ExportedFile> SystemdUnits(const ExportedRobot& exported, const SystemdOptions& options) {
  return UnitsWriter(exported, options).Write();
}

}  // namespace hgros::cli
