#pragma once

#include <span>
#include <string>
#include <vector>

#include "arguments/command.hpp"

namespace hgros::cli {

/// What can stand at the end of a command line that is being typed.
struct Completion {
  struct Word {
    std::string word;
    std::string text;  ///< What it means; may be empty.
  };
  std::vector<Word> words;            ///< All that begin as typed.
  ValueKind kind = ValueKind::kText;  ///< Also names of this kind from the running robot, or files.
  bool many = false;                  ///< For `kind`: any number of values can follow.
  ValueKind next = ValueKind::kText;  ///< The positional argument after it.
  std::string typed;                  ///< The beginning of such a name.
  std::string before;                 ///< Goes before each name: "--option=", or empty.
  std::vector<std::string> given;     ///< The positional arguments before.
  std::vector<std::string> options;   ///< The options before, each followed by its value.
};

/// `words`: the command line after "hgros", the last one unfinished, maybe empty.
[[nodiscard]] Completion CompletionOf(std::span<const std::string> words, std::span<const CommandEntry> commands);

}  // namespace hgros::cli
