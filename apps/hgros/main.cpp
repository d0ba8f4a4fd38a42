// hgros: one command to see, check, measure and steer a running robot. commands/ has one file per command.
#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <exception>
#include <string>
#include <vector>

#include "arguments/help.hpp"
#include "commands/commands.hpp"
#include "hgros/base/error.hpp"
#include "terminal/console.hpp"
#include "terminal/pause.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

int Run(const CommandEntry& entry, const std::vector<std::string>& words, Surroundings& surroundings) {
  for (const std::string& word : words) {
    if (word == "--") break;
    if (word != "-h" && word != "--help") continue;
    surroundings.console.Write(HelpOf(surroundings.console, entry, Commands()));
    return kDone;
  }
  if (entry.family()) {
    surroundings.console.Write(HelpOf(surroundings.console, entry, Commands()));
    return kWrongUsage;
  }
  const std::unique_ptr<Command> command = entry.make();
  Arguments arguments;
  command->Declare(arguments);
  arguments.Parse(words);
  return command->Run(surroundings);
}

// A command that the user has ended has nothing more to say.
int RunUntilItEnds(const CommandEntry& entry, const std::vector<std::string>& words, Console& console) {
  Pause pause;
  console.GiveUpWhen(pause.ended());
  Surroundings surroundings{console, pause};
  try {
    const int code = Run(entry, words, surroundings);
    pause.EndBySignal();
    return code;
  } catch (...) {
    pause.EndBySignal();
    throw;
  }
}

// Standard streams that are closed would otherwise be what is opened next. Using these fails as before.
void FillStandardStreams() {
  int unused = 0;
  while (unused >= 0 && unused <= STDERR_FILENO) unused = open("/dev/null", O_RDONLY);
  if (unused >= 0) close(unused);
}

int Main(std::vector<std::string> words) {
  FillStandardStreams();
  (void)std::signal(SIGPIPE, SIG_IGN);  // Writing fails instead, so that the session says goodbye.
  (void)std::signal(SIGCHLD,
                    SIG_DFL);  // A parent that ignores it leaves that to us, and we need our children's status.
  Console console;
  try {
    if (words.empty() || words.front() == "-h" || words.front() == "--help") {
      console.Write(HelpOfAll(console, Commands()));
      return words.empty() ? kWrongUsage : kDone;
    }
    if (words.front() == "--version") {
      if (words.size() > 1) throw UsageError("--version takes nothing else, but there is \"" + words[1] + "\".");
      console.Line("hgros " HGROS_VERSION);
      return kDone;
    }
    const CommandEntry& entry = TakeCommand(words);
    return RunUntilItEnds(entry, words, console);
  } catch (const OutputClosed&) {
    return kDone;
  } catch (const UsageError& error) {
    console.Say(Visible(error.what()));
    return kWrongUsage;
  } catch (const ConfigError& error) {
    console.Say(Visible(error.what()));
    return kWrongUsage;
  } catch (const TimedOut& error) {
    console.Say(Visible(error.what()));
    return kTimedOut;
  } catch (const std::exception& error) {
    console.Say(Visible(error.what()));
    return kFailed;
  }
}

}  // namespace
}  // namespace hgros::cli

int main(int argc, char** argv) { return hgros::cli::Main(std::vector<std::string>(argv + 1, argv + argc)); }
