#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace hgros::cli {

/// The command line is wrong; what() says what is wrong and how to mend it.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What a value names, so that shells can complete it. kParamSession: a session that offers parameters.
enum class ValueKind {
  kText,
  kName,  ///< Of something that cannot be looked up.
  kChannel,
  kSession,
  kParamSession,
  kNode,
  kService,
  kParam,
  kFrame,
  kType,
  kFile,
  kCommand
};

/// An option, a flag or a positional argument.
struct Argument {
  std::string names;  ///< "--once", "-n,--count", or of a positional argument "CHANNEL".
  std::string value;  ///< What follows an option, such as "N"; empty: a flag or a positional argument.
  std::string text;   ///< One sentence for the help, without a period.
  ValueKind kind = ValueKind::kText;
  std::vector<std::string> choices = {};  ///< The only values; empty: any.
  bool required = false;
  bool many = false;  ///< More than one value.

  [[nodiscard]] bool positional() const noexcept { return names.front() != '-'; }
};

/// The arguments of a command and the variables that take their values, which must live until Parse() returns.
class Arguments {
 public:
  /// Returns what is wrong with the values; empty: nothing.
  using Setter = std::function<std::string(const std::vector<std::string>&)>;

  void Flag(std::string names, bool& variable, std::string text);
  void Option(std::string names, std::string value, std::string& variable, std::string text,
              ValueKind kind = ValueKind::kText);
  void Option(std::string names, std::string value, std::vector<std::string>& variable, std::string text,
              ValueKind kind = ValueKind::kText);
  /// A number above zero, or also zero.
  void Option(std::string names, std::string value, std::optional<double>& variable, std::string text,
              bool also_zero = false);
  void Option(std::string names, std::string value, std::optional<std::uint64_t>& variable, std::string text);
  /// --once and -n,--count: how many are shown. Empty: no limit.
  void Count(std::optional<std::uint64_t>& count, std::string once_text, std::string count_text);
  void Choice(std::string names, std::string& variable, std::vector<std::string> choices, std::string text);
  void Positional(Argument argument, std::string& variable);
  void Positional(Argument argument, std::vector<std::string>& variable);

  /// Sets the variables. Throws UsageError.
  void Parse(std::span<const std::string> words) const;
  [[nodiscard]] const std::vector<Argument>& all() const noexcept { return all_; }

 private:
  void Add(Argument argument, Setter setter);

  std::vector<Argument> all_;
  std::vector<Setter> setters_;  // One for each of all_.
};

}  // namespace hgros::cli
