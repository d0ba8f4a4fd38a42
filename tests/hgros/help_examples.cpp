#include "hgros/help_examples.hpp"

#include "hgros/command_run.hpp"

namespace hgros::cli {

std::vector<std::vector<std::string>> ExamplesOf(const std::string& command) {
  constexpr std::string_view kBefore = "  hgros ";
  const std::string help = RunToEnd({"help", command}).out;
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
