// The commands that change parameters or keep them in files: set, save and load.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "commands/commands.hpp"
#include "robot/offered_params.hpp"
#include "terminal/output_file.hpp"
#include "terminal/records.hpp"

namespace hgros::cli {
namespace {

// Throws if a parameter does not exist, also one within a map that is set. What is within lists is a value.
void RequireExisting(const ParamView& all, const ParamPath& path, const ParamNode* value) {
  (void)Existing(all, path.ToString(), " With --create it is created.");
  if (value == nullptr || value->kind != ParamNode::Kind::kMap) return;
  for (const auto& [key, inner] : value->entries) RequireExisting(all, path.Below(key), inner.get());
}

// Changes them and shows what is different afterwards.
void Apply(OfferedParams& params, const std::vector<ParamChange>& changes, bool create, const OutputStyle& style,
           Console& console) {
  const ParamView before = params.Snapshot();
  for (const ParamChange& change : changes) {
    if (!create) RequireExisting(before, ParamPath::Parse(change.path), change.value ? &*change.value : nullptr);
  }
  params.Change(changes, create ? IfMissing::kCreate : IfMissing::kRefuse);
  const ParamView after = params.Snapshot();
  Records records(console, style, {{"session", ""}, {"path", "PARAMETER"}, {"before", "BEFORE"}, {"value", "VALUE"}});
  for (const ParamChange& change : changes) {
    const ParamNodePtr old_value = before.At(change.path).node();
    const ParamNodePtr value = after.At(change.path).node();
    if (old_value != nullptr && value != nullptr && old_value->SameValue(*value)) continue;
    records.Add({params.name(), change.path, CellOf(old_value), CellOf(value)});
  }
  records.End();
  if (records.size() == 0) console.Say("The parameters have these values already.");
}

ParamChange ChangeOf(const std::vector<ParamDeclaration>& known, const std::string& path, const std::string& argument) {
  const bool is_text = std::ranges::any_of(known, [whole = ParamPath::Parse(path).ToString()](const auto& one) {
    return one.path == whole && one.type == "text";
  });
  if (is_text && !argument.starts_with('"') && !argument.starts_with('\'')) {
    return {path, ParamNode::Text(argument, true)};
  }
  // A server reads a value as a program reads its command line.
  const ParamServer reader({.overrides = {{"value", argument, "the value of " + path}}});
  const ParamNodePtr value = reader["value"].node();
  return {path, value == nullptr ? ParamNode() : *value};
}

class ParamSet final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional(
        {"SESSION", "", "The session; can be left out if only one offers parameters", ValueKind::kParamSession},
        session_);
    Argument assignments{"PATH VALUE", "", "Parameters and their new values, as YAML", ValueKind::kParam, {}, true};
    arguments.Positional(std::move(assignments), words_);
    arguments.Flag("--create", create_, "Also set parameters that do not exist");
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Changes one parameter or several at once: all of them, or none if one is refused. Shows the values before "
           "and after.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros param set robot matcher.range 12.5", "Changes one parameter."},
            {"hgros param set robot matcher.range 10 matcher.method ndt", "Changes two at once."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  std::string session_;
  std::vector<std::string> words_;
  bool create_ = false;
  RobotOptions options_;
};

int ParamSet::Run(Surroundings& surroundings) {
  const bool named = words_.size() % 2 == 0;
  if (words_.empty()) throw UsageError("PATH and VALUE are missing.");
  if (!named) words_.insert(words_.begin(), session_);
  Robot robot(options_, surroundings);
  const std::vector<std::string> sessions = ParamSessions(robot);
  if (!named && std::ranges::find(sessions, session_) != sessions.end()) {
    throw UsageError("The last parameter, " + words_.back() + ", has no value.");
  }
  OfferedParams params(robot, options_, named ? session_ : OnlyParamSession(robot));
  const std::vector<ParamDeclaration> known = params.Declarations("");
  std::vector<ParamChange> changes;
  for (std::size_t i = 0; i < words_.size(); i += 2) changes.push_back(ChangeOf(known, words_[i], words_[i + 1]));
  Apply(params, changes, create_, options_.style, surroundings.console);
  return kDone;
}

class ParamSave final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional(
        {"SESSION", "", "The session; can be left out if only one offers parameters", ValueKind::kParamSession},
        session_);
    arguments.Positional({"FILE", "", "The file to write; without it, standard output", ValueKind::kFile}, file_);
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Writes all parameters of a session as YAML, which the program and `hgros param load` read. A file that "
           "exists is replaced.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros param save robot", "Shows all parameters as YAML."},
            {"hgros param save robot tuned.yaml", "Writes them into a file."}};
  }
  int Run(Surroundings& surroundings) override {
    Robot robot(options_, surroundings);
    OfferedParams params(robot, options_, session_.empty() ? OnlyParamSession(robot) : session_);
    const ParamView all = params.Snapshot();
    WriteTo(surroundings.console, file_, all.size() == 0 ? "{}\n" : all.ToYaml());
    return kDone;
  }

 private:
  std::string session_;
  std::string file_;
  RobotOptions options_;
};

class ParamLoad final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional(
        {"SESSION", "", "The session; can be left out if only one offers parameters", ValueKind::kParamSession},
        session_);
    arguments.Positional({"FILE", "", "The YAML file", ValueKind::kFile}, file_);
    arguments.Flag("--create", create_, "Also set parameters that do not exist");
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Sets parameters to the values of a YAML file: all of them, or none if one is refused. Parameters that are "
           "not in the file stay as they are. Shows the values that have changed.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros param load robot tuned.yaml", "Sets all values of the file."},
            {"hgros param load robot new.yaml --create", "Also adds parameters that the session does not have."}};
  }
  int Run(Surroundings& surroundings) override {
    if (session_.empty()) throw UsageError("FILE is missing.");
    const std::string file = file_.empty() ? session_ : file_;
    const ParamServer reader({.files = {file}});
    std::vector<ParamChange> changes;
    for (const auto& [path, value] : ValuesOf(reader.Snapshot())) changes.push_back({path, *value});
    if (changes.empty()) throw UsageError("The file " + file + " has no parameters.");
    Robot robot(options_, surroundings);
    OfferedParams params(robot, options_, file_.empty() ? OnlyParamSession(robot) : session_);
    Apply(params, changes, create_, options_.style, surroundings.console);
    return kDone;
  }

 private:
  std::string session_;
  std::string file_;
  bool create_ = false;
  RobotOptions options_;
};

}  // namespace

std::unique_ptr<Command> MakeParamLoad() { return std::make_unique<ParamLoad>(); }
std::unique_ptr<Command> MakeParamSave() { return std::make_unique<ParamSave>(); }
std::unique_ptr<Command> MakeParamSet() { return std::make_unique<ParamSet>(); }

}  // namespace hgros::cli
