#include "arguments/help.hpp"

#include <string>
#include <vector>

#include "commands/commands.hpp"
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
    const CommandEntry& entry = TakeCommand(name_);
    if (!name_.empty()) throw UsageError("\"" + name_.front() + "\" is one argument too many.");
    console.Write(HelpOf(console, entry, Commands()));
    return kDone;
  }

 private:
  std::vector<std::string> name_;
};

}  // namespace

std::unique_ptr<Command> MakeHelp() { return std::make_unique<Help>(); }

}  // namespace hgros::cli
