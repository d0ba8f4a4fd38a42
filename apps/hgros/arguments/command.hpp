#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arguments/arguments.hpp"
#include "hgros/base/error.hpp"

namespace hgros::cli {

/// What a program gets when the command ends. docs/cli.md lists them.
enum ExitCode : int {
  kDone = 0,
  kFailed = 1,      ///< What was asked for is not there, was refused, or something is wrong.
  kWrongUsage = 2,  ///< The command line, or a file that it names.
  kTimedOut = 3,    ///< --timeout came first.
};

/// --timeout came first; what() says for what the command has waited.
class TimedOut : public Error {
 public:
  using Error::Error;
};

class Console;
class Pause;

/// What a command runs with.
struct Surroundings {
  Console& console;
  Pause& pause;
};

/// A line that the help shows, with what it does. A test runs them.
struct Example {
  std::string line;
  std::string text;
};

/// One command: `hgros NAME ...`.
class Command {
 public:
  virtual ~Command() = default;
  /// Adds its arguments. Called once.
  virtual void Declare(Arguments& arguments) = 0;
  /// Sentences for the help and the manual page, below the summary.
  [[nodiscard]] virtual std::string Description() const = 0;
  [[nodiscard]] virtual std::vector<Example> Examples() const = 0;
  /// Called after its variables were set. Returns an ExitCode. Throws Error for what went wrong, and UsageError.
  virtual int Run(Surroundings& surroundings) = 0;
};

/// A command in the list of all. "param" is a family of commands: it has no `make`, and "param get" is one of its
/// commands. Scripts call the hidden commands; their names begin with "__".
struct CommandEntry {
  std::string_view name;
  std::string_view summary;  ///< One line without a period.
  std::string_view group;    ///< The heading in `hgros help`.
  std::unique_ptr<Command> (*make)();

  [[nodiscard]] bool family() const noexcept { return make == nullptr; }
  [[nodiscard]] bool hidden() const noexcept { return name.starts_with("__"); }
  /// Whether it is a command of this family.
  [[nodiscard]] bool IsIn(const CommandEntry& other) const noexcept {
    return other.family() && name.size() > other.name.size() && name.starts_with(other.name) &&
           name[other.name.size()] == ' ';
  }
  [[nodiscard]] bool IsInAny() const noexcept { return name.find(' ') != std::string_view::npos; }
};

}  // namespace hgros::cli
