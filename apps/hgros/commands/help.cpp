#include "arguments/help.hpp"

#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "hgros/base/names.hpp"
#include "terminal/console.hpp"

namespace hgros::cli {
namespace {

class Help final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"COMMAND", "", "The command to explain; without it, all are listed", ValueKind::kCommand},
                         name_);
  }
  [[nodiscard]] std::string Description() const override {
    return "Explains a command, with its options and examples.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros help", "Lists all commands."}, {"hgros help echo", "Explains `hgros echo`."}};
  }

  int Run(Surroundings& surroundings) override {
    Console& console = surroundings.console;
    if (name_.empty()) {
      console.Write(HelpOfAll(console, Commands()));
      return kDone;
    }
    const CommandEntry* entry = FindCommand(name_);
    if (entry == nullptr) throw UsageError(UnknownCommand(name_));
    console.Write(HelpOf(console, *entry));
    return kDone;
  }

 private:
  std::string name_;
};

}  // namespace

std::string UnknownCommand(std::string_view name) {
  std::vector<std::string> names;
  for (const CommandEntry& entry : Commands()) names.emplace_back(entry.name);
  const std::string nearest = NearestName(name, names);
  return "There is no command \"" + std::string(name) + "\"." +
         (nearest.empty() ? " `hgros help` lists all." : " Did you mean " + nearest + "?");
}

std::unique_ptr<Command> MakeHelp() { return std::make_unique<Help>(); }

}  // namespace hgros::cli
