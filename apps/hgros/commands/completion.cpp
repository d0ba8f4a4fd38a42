// completion prints the scripts for shells; they call __complete.
#include "arguments/completion.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <exception>
#include <string>
#include <vector>

#include "arguments/shell_scripts.hpp"
#include "commands/commands.hpp"
#include "robot/live_names.hpp"
#include "terminal/console.hpp"

namespace hgros::cli {
namespace {

class CompletionCommand final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Choice("SHELL", shell_, {"bash", "zsh", "fish"}, "The shell");
  }
  [[nodiscard]] std::string Description() const override {
    return "Prints a script that completes commands, options and the names of channels, sessions, nodes, services, "
           "parameters and frames that are there right now. A package of HyperGraph ROS has these scripts installed; "
           "otherwise load them in the file that your shell reads at its start.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros completion bash >> ~/.bashrc", "Completes in each bash that is started from now on."},
            {"hgros completion fish > ~/.config/fish/completions/hgros.fish", "The same for fish."}};
  }
  int Run(Surroundings& surroundings) override {
    if (shell_.empty()) throw UsageError("SHELL is missing: bash, zsh or fish.");
    surroundings.console.Write(CompletionScript(shell_));
    return kDone;
  }

 private:
  std::string shell_;
};

class CompleteCommand final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"WORD", "", "The command line after hgros, up to the cursor"}, words_);
  }
  [[nodiscard]] std::string Description() const override { return "Answers the scripts of `hgros completion`."; }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros __complete -- echo sc", "Shows the channels that begin with sc."},
            {"hgros __complete -- list --js", "Shows the options that begin with --js."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  std::vector<std::string> words_;
};

int CompleteCommand::Run(Surroundings& surroundings) {
  // Whatever goes wrong, nothing may appear in the line that is being typed.
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere >= 0) dup2(nowhere, STDERR_FILENO);
  const Completion completion = CompletionOf(words_, Commands());
  std::string out;
  for (const auto& [word, text] : completion.words) out += word + (text.empty() ? "" : "\t" + text) + "\n";
  if (completion.kind == ValueKind::kFile) out += ":file\n";
  surroundings.console.Write(out);
  out.clear();
  for (const std::string& name : LiveNames(completion, surroundings)) out += name + "\n";
  surroundings.console.Write(out);
  return kDone;
}

}  // namespace

std::unique_ptr<Command> MakeComplete() { return std::make_unique<CompleteCommand>(); }
std::unique_ptr<Command> MakeCompletion() { return std::make_unique<CompletionCommand>(); }

}  // namespace hgros::cli
