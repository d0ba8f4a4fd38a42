#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "commands/commands.hpp"

namespace hgros::cli {

/// The words of a line as a shell splits them, up to a pipe or a file, with simple quotes.
inline std::vector<std::string> ShellWords(const std::string& line) {
  std::vector<std::string> words;
  std::string word;
  bool there = false;
  char quote = 0;
  for (const char c : line + " ") {
    if (quote != 0 ? c == quote : c == '\'' || c == '"') {
      quote = quote != 0 ? '\0' : c;
      there = true;
    } else if (quote == 0 && c == ' ') {
      if (there) words.push_back(word);
      word.clear();
      there = false;
    } else if (quote == 0 && (c == '|' || c == '>')) {
      break;
    } else {
      word += c;
      there = true;
    }
  }
  return words;
}

/// The examples of the command, at least two, without "hgros".
inline std::vector<std::vector<std::string>> ExamplesOf(const std::string& command) {
  std::vector<std::vector<std::string>> examples;
  for (const Example& example : FindCommand(command)->make()->Examples()) {
    examples.push_back(ShellWords(example.line));
    examples.back().erase(examples.back().begin());
  }
  EXPECT_GE(examples.size(), 2U) << command;
  return examples;
}

}  // namespace hgros::cli
