#include "arguments/manual.hpp"

#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "terminal/console.hpp"
#include "terminal/output_file.hpp"

namespace hgros::cli {
namespace {

class Manual final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"COMMAND", "", "The command; without it, hgros as a whole", ValueKind::kCommand}, name_);
    arguments.Option("--folder", "FOLDER", folder_, "Write all pages into this folder");
  }
  [[nodiscard]] std::string Description() const override { return "Writes manual pages for the build."; }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros __man", "Prints the page of hgros."}, {"hgros __man echo | man -l -", "Shows that of a command."}};
  }
  int Run(Surroundings& surroundings) override {
    Console& console = surroundings.console;
    if (!name_.empty()) {
      console.Write(ManualOf(HGROS_VERSION, TakeCommand(name_), Commands()));
    } else if (folder_.empty()) {
      console.Write(ManualOfAll(HGROS_VERSION, Commands()));
    } else {
      WriteTo(console, folder_ + "/hgros.1", ManualOfAll(HGROS_VERSION, Commands()));
      for (const CommandEntry& entry : Commands()) {
        if (entry.hidden()) continue;
        WriteTo(console, folder_ + "/" + ManualName(entry) + ".1", ManualOf(HGROS_VERSION, entry, Commands()));
      }
    }
    return kDone;
  }

 private:
  std::vector<std::string> name_;
  std::string folder_;
};

}  // namespace

std::unique_ptr<Command> MakeManual() { return std::make_unique<Manual>(); }

}  // namespace hgros::cli
