#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "check/config_schema.hpp"
#include "check/deployment.hpp"
#include "check/ignored_findings.hpp"
#include "commands/commands.hpp"
#include "drawing/graph_drawing.hpp"
#include "hgros/placement/robot_file.hpp"
#include "launch/host_networks.hpp"
#include "launch/robot_check.hpp"
#include "launch/robot_graph.hpp"
#include "terminal/console.hpp"
#include "terminal/output_file.hpp"
#include "terminal/records.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

class CheckCommand final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"FILE",
                          "",
                          "The file of a robot or a session, or FILE+FILE for a session that loads several",
                          ValueKind::kFile,
                          {},
                          false,
                          true},
                         files_);
    arguments.Option("--section", "NAME", sections_, "A section of the program's own; others are refused then");
    arguments.Flag("-v,--verbose", verbose_, "Also notes: what is worth knowing although nothing is wrong");
    arguments.Flag("--json", style_.json, "One JSON object per line");
    arguments.Flag("--svg", svg_, "Draw the graph that the files describe");
    arguments.Flag("--schema", schema_, "Print the JSON Schema of these files, for editors");
    arguments.Flag("--robot-file", robot_, "With --schema: that of robot files");
    arguments.Option("-o,--output", "FILE", output_, "Write the picture or the schema to this file", ValueKind::kFile);
  }
  [[nodiscard]] std::string Description() const override {
    return "Checks configuration files before anything runs: each file as strictly as a session reads it, but with all "
           "of its faults, and the files of several sessions against each other: endpoints, lists of channels, keys, "
           "time, heartbeats. Of a robot file also the components: each is constructed once, and what they use is "
           "compared. "
           "Ends with code 1 if something is wrong. The comment `# hgros check: ignore CHANNEL` in "
           "a line, or in the line above, ignores what is said about this channel there. In a robot file, it ignores "
           "warnings.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros check cart.yaml desk.yaml", "Checks the files of two sessions, and against each other."},
            {"hgros check common.yaml+lidar.yaml desk.yaml --svg -o robot.svg",
             "Draws a session that loads two files, and one that loads a third."},
            {"hgros check --schema --section gripper -o hgros.schema.json",
             "Writes a schema that also allows a section of the program."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  void CheckUsage() const;
  void Write(Console& console, const FileFindings& findings) const;

  std::vector<std::string> files_;
  std::vector<std::string> sections_;
  std::string output_;
  bool verbose_ = false;
  bool svg_ = false;
  bool schema_ = false;
  bool robot_ = false;
  OutputStyle style_;
};

void CheckCommand::CheckUsage() const {
  if (style_.json + svg_ + schema_ > 1) throw UsageError("--json, --svg and --schema exclude each other.");
  if (!output_.empty() && !svg_ && !schema_) throw UsageError("--output needs --svg or --schema.");
  if (robot_ && !schema_) throw UsageError("--robot-file needs --schema.");
  if (robot_ && !sections_.empty()) throw UsageError("--robot-file and --section exclude each other.");
  if (schema_ && !files_.empty()) throw UsageError("--schema takes no files.");
  if (!schema_ && files_.empty()) throw UsageError("FILE is missing: name the configuration files of each session.");
  for (const std::string& files : files_) {
    for (const std::filesystem::path& file : FilesOf(files)) {
      std::error_code error;
      if (!std::filesystem::exists(file, error)) throw UsageError("There is no file \"" + file.string() + "\".");
      // Files are read twice, which a pipe does not allow. A folder has an error of its own.
      if (!std::filesystem::is_regular_file(file, error) && !std::filesystem::is_directory(file, error)) {
        throw UsageError("\"" + file.string() + "\" is a pipe or a device. Save its text as a file and name that.");
      }
    }
  }
}

std::string TextOf(const Console& console, const FileFinding& finding) {
  const Style style = finding.severity == Severity::kFault     ? Style::kRed
                      : finding.severity == Severity::kWarning ? Style::kYellow
                                                               : Style::kDim;
  const std::string fix = finding.fix.empty() ? "" : " " + console.Styled(Style::kDim, Visible(finding.fix));
  return console.Styled(Style::kBold, Visible(finding.at.ToString())) + ": " +
         console.Styled(style, NameOf(finding.severity)) + ": " + Visible(finding.what) + fix;
}

void CheckCommand::Write(Console& console, const FileFindings& findings) const {
  std::size_t shown = 0;
  Records records(
      console, style_,
      {{"severity", ""}, {"check", ""}, {"file", ""}, {"line", ""}, {"column", ""}, {"what", ""}, {"fix", ""}});
  const auto number = [](int value) { return value > 0 ? Cell(std::int64_t{value}) : Cell(); };
  for (const FileFinding& one : findings) {
    if (one.severity == Severity::kNote && !verbose_) continue;
    ++shown;
    if (style_.json) {
      records.Add({NameOf(one.severity), one.check, one.at.file, number(one.at.line), number(one.at.column), one.what,
                   one.fix});
    } else {
      console.Line(TextOf(console, one));
    }
  }
  const std::size_t hidden = findings.size() - shown;
  if (style_.json || !console.interactive()) return;
  const std::string end = std::string(shown > 0 ? "" : "Nothing is wrong.") + (shown > 0 || hidden == 0 ? "" : " ") +
                          (hidden == 0 ? "" : "Notes: " + std::to_string(hidden) + " with --verbose.");
  if (!end.empty()) console.Line(console.Styled(Style::kDim, end));
}

const FilePosition& AtOf(const RobotFile& robot, const std::string& unit) {
  if (const RobotProcess* process = robot.FindProcess(unit)) return process->at;
  return std::ranges::find(robot.programs, unit, &RobotProgram::name)->at;
}

// Shows the endpoints that are derived for processes and programs with channels to other hosts.
void CheckHosts(const RobotFile& robot, const RobotGraph& graph, FileFindings& findings) {
  for (const auto& network : HostNetworks(robot, graph)) {
    const std::string& process = network.first;
    const std::string& yaml = network.second;
    const Config config = Config::Parse(yaml.substr(0, yaml.find("  security:")));
    const auto note = [&, &at = AtOf(robot, process)](const EndpointConfig& one, std::string_view does) {
      std::string channels;
      for (const std::string& channel : one.channels) channels += (channels.empty() ? "" : ", ") + channel;
      findings.push_back({Severity::kNote,
                          "host",
                          at,
                          "\"" + process + "\" " + std::string(does) + " " + one.endpoint + ": " + channels + ".",
                          {}});
    };
    for (const EndpointConfig& one : config.publishers) note(one, "publishes for other hosts at");
    for (const EndpointConfig& one : config.subscribers) note(one, "hears another host at");
  }
}

// A robot file, and its components if nothing is wrong with the file.
void CheckRobotFile(const std::string& file, Pause& pause, FileFindings& findings) {
  const CheckedRobotFile checked = RobotFile::Check(file);
  for (const ConfigError& fault : checked.faults) findings.push_back(FindingOf(fault));
  if (!checked.faults.empty()) return;
  const ComponentCatalog catalog;
  const CheckedRobot components = CheckRobot(checked.robot, catalog, pause);
  for (const RobotFinding& one : components.findings) {
    const Severity severity = one.fault ? Severity::kFault : Severity::kWarning;
    findings.push_back({severity, "component", one.at, one.what, one.fix});
  }
  try {
    CheckHosts(checked.robot, RobotGraph(checked.robot, components.descriptions), findings);
  } catch (const ConfigError& error) {
    findings.push_back(FindingOf(error));
  }
}

int CheckCommand::Run(Surroundings& surroundings) {
  CheckUsage();
  Console& console = surroundings.console;
  if (schema_) {
    WriteTo(console, output_, robot_ ? RobotSchema() : ConfigSchemaWith(sections_));
    return kDone;
  }
  FileFindings findings;
  std::vector<DescribedProcess> processes;
  for (const std::string& files : files_) {
    if (RobotFile::Is(files, sections_)) {
      CheckRobotFile(files, surroundings.pause, findings);
    } else if (std::optional<DescribedProcess> process = ReadProcess(files, sections_, findings)) {
      processes.push_back(*std::move(process));
    }
  }
  const Deployment deployment(processes);
  if (svg_) {
    const auto fault = std::ranges::find(findings, Severity::kFault, &FileFinding::severity);
    if (fault != findings.end()) throw Error(fault->what, fault->at.ToString(), fault->fix);
    WriteTo(console, output_, DrawSvg(deployment.Graph(), style_));
    return kDone;
  }
  CheckEndpoints(deployment, findings);
  CheckChannelLists(deployment, findings);
  CheckKeys(deployment, findings);
  CheckSettings(deployment, findings);
  RemoveIgnored(findings);
  std::set<std::pair<std::string, std::string>> told;  // A file that several others include is read for each of them.
  std::erase_if(findings, [&](const auto& one) { return !told.emplace(one.at.ToString(), one.what).second; });
  std::ranges::stable_sort(findings, {}, &FileFinding::severity);
  Write(console, findings);
  const bool wrong =
      std::ranges::any_of(findings, [](const FileFinding& one) { return one.severity != Severity::kNote; });
  return wrong ? kFailed : kDone;
}

}  // namespace

std::unique_ptr<Command> MakeCheck() { return std::make_unique<CheckCommand>(); }

}  // namespace hgros::cli
