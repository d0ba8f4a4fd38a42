// The command line takes any words. They are a call of a command or refused with UsageError, and what they could go on
// with is known, in bounded time. No value is changed on its way. The input is one word per line.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arguments/completion.hpp"
#include "commands/commands.hpp"

namespace {

using Words = std::vector<std::string>;

void Require(bool holds) {
  if (!holds) __builtin_trap();
}

// As argv has them: a word has no zero.
Words WordsOf(std::string_view text) {
  Words words;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    words.emplace_back(text.substr(0, std::min(text.find('\0'), end)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return words;
}

void ParseAsCommand(Words words) {
  try {
    const hgros::cli::CommandEntry& entry = hgros::cli::TakeCommand(words);
    if (entry.family()) return;
    const std::unique_ptr<hgros::cli::Command> command = entry.make();
    hgros::cli::Arguments arguments;
    command->Declare(arguments);
    arguments.Parse(words);
  } catch (const hgros::cli::UsageError& error) {
    Require(*error.what() != '\0');
  }
}

void ParseAsValues(const Words& words) {
  Words values;
  Words repeated;
  std::string single;
  hgros::cli::Arguments arguments;
  arguments.Positional({"VALUE", "", "Any words"}, values);
  arguments.Option("-r,--repeated", "TEXT", repeated, "Any words");
  arguments.Option("-s,--single", "TEXT", single, "The last word");
  Words line;
  for (const std::string& word : words) {
    line.push_back("--repeated=" + word);
    line.push_back("--single=" + word);
  }
  line.emplace_back("--");
  line.insert(line.end(), words.begin(), words.end());
  try {
    arguments.Parse(line);
  } catch (const hgros::cli::UsageError&) {
    Require(false);
  }
  Require(values == words && repeated == words && single == words.back());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Words words = WordsOf({reinterpret_cast<const char*>(data), size});
  if (words.empty()) return 0;
  ParseAsCommand(words);
  ParseAsValues(words);
  (void)hgros::cli::CompletionOf(words, hgros::cli::Commands());
  return 0;
}
