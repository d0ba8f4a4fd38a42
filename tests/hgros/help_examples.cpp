#include "hgros/help_examples.hpp"

#include <sstream>

#include "hgros/command_run.hpp"

namespace hgros::cli {

std::vector<std::vector<std::string>> ExamplesOf(const std::string& command) {
  constexpr std::string_view kBefore = "  hgros ";
  std::vector<std::string> line_of_help{"help"};
  std::istringstream names(command);
  for (std::string name; names >> name;) line_of_help.push_back(name);
  const std::string help = RunToEnd(line_of_help).out;
  std::vector<std::vector<std::string>> examples;
  for (const std::string& line : LinesOf(help.substr(help.find("Examples:")))) {
    if (!line.starts_with(kBefore)) continue;
    std::vector<std::string>& words = examples.emplace_back(1);
    bool quoted = false;
    for (const char c : line.substr(kBefore.size())) {
      if (c == '\'') {
        quoted = !quoted;
      } else if (c == ' ' && !quoted) {
        words.emplace_back();
      } else {
        words.back() += c;
      }
    }
  }
  return examples;
}

}  // namespace hgros::cli
