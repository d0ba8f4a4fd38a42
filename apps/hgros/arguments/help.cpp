#include "arguments/help.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include "terminal/console.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kMostColumns = 100;

// The text in lines that fit, each after `indent` spaces. The first line follows what stands there already.
std::string Folded(std::string_view text, std::size_t indent) {
  std::string folded;
  std::size_t column = indent;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    if (column > indent && column + 1 + end > kMostColumns) {
      folded += "\n" + std::string(indent, ' ');
      column = indent;
    } else if (column > indent) {
      folded += ' ';
      ++column;
    }
    folded += text.substr(0, end);
    column += end;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return folded;
}

// One line for each command, after the longest name.
std::string Listed(const Console& console, std::span<const CommandEntry* const> entries) {
  std::size_t width = 10;
  for (const CommandEntry* entry : entries) width = std::max(width, entry->name.size());
  std::string list;
  for (const CommandEntry* entry : entries) {
    list += "  " + console.Styled(Style::kCyan, entry->name) + std::string(width + 2 - entry->name.size(), ' ') +
            Folded(entry->summary, width + 4) + "\n";
  }
  return list;
}

std::string HelpOfFamily(const Console& console, const CommandEntry& family, std::span<const CommandEntry> commands) {
  std::vector<const CommandEntry*> members;
  for (const CommandEntry& entry : commands) {
    if (entry.IsIn(family)) members.push_back(&entry);
  }
  return std::string(family.summary) + ".\n\n" + console.Styled(Style::kBold, "Usage:") + " hgros " +
         std::string(family.name) + " COMMAND ...\n\n" + console.Styled(Style::kBold, "Commands:") + "\n" +
         Listed(console, members) + "\n`hgros help " + std::string(family.name) +
         " COMMAND` explains a command, with examples.\n";
}

}  // namespace

std::string NamesOf(const Argument& argument) {
  if (argument.positional()) return argument.names + (argument.many ? "..." : "");
  std::string names = argument.names;
  for (std::size_t comma = names.find(','); comma != std::string::npos; comma = names.find(',', comma + 2)) {
    names.insert(comma + 1, " ");
  }
  return names + (argument.value.empty() ? "" : " " + argument.value);
}

std::string TextOf(const Argument& argument) {
  if (argument.choices.empty()) return argument.text;
  std::string choices;
  for (const std::string& choice : argument.choices) choices += (choices.empty() ? "" : ", ") + choice;
  return argument.text + ": " + choices;
}

std::string UsageOf(const CommandEntry& entry, const Arguments& arguments) {
  std::string usage = "hgros " + std::string(entry.name);
  bool options = false;
  for (const Argument& argument : arguments.all()) {
    options = options || !argument.positional();
    if (!argument.positional()) continue;
    usage += " ";
    usage += argument.required ? NamesOf(argument) : "[" + NamesOf(argument) + "]";
  }
  return usage + (options ? " [OPTIONS]" : "");
}

std::string HelpOfAll(const Console& console, std::span<const CommandEntry> commands) {
  std::string help = "hgros sees, checks, measures and steers running robots.\n\n" +
                     console.Styled(Style::kBold, "Usage:") + " hgros COMMAND ...\n";
  std::vector<std::string_view> groups;
  for (const CommandEntry& entry : commands) {
    if (!entry.hidden() && std::ranges::find(groups, entry.group) == groups.end()) groups.push_back(entry.group);
  }
  for (const std::string_view group : groups) {
    std::vector<const CommandEntry*> members;
    for (const CommandEntry& entry : commands) {
      if (entry.group == group && !entry.hidden() && !entry.IsInAny()) members.push_back(&entry);
    }
    help += "\n" + console.Styled(Style::kBold, group) + "\n" + Listed(console, members);
  }
  return help + "\n`hgros help COMMAND` explains a command, with examples.\n`hgros --version` tells the version.\n";
}

std::string HelpOf(const Console& console, const CommandEntry& entry, std::span<const CommandEntry> commands) {
  if (entry.family()) return HelpOfFamily(console, entry, commands);
  const std::unique_ptr<Command> command = entry.make();
  Arguments arguments;
  command->Declare(arguments);
  std::string help = std::string(entry.summary) + ".\n\n" + Folded(command->Description(), 0) + "\n\n" +
                     console.Styled(Style::kBold, "Usage:") + " " + UsageOf(entry, arguments) + "\n";
  std::size_t width = 0;
  for (const Argument& argument : arguments.all()) width = std::max(width, NamesOf(argument).size());
  width = std::min<std::size_t>(width, 28);
  for (const bool positional : {true, false}) {
    bool first = true;
    for (const Argument& argument : arguments.all()) {
      if (argument.positional() != positional) continue;
      if (first) help += "\n" + console.Styled(Style::kBold, positional ? "Arguments:" : "Options:") + "\n";
      first = false;
      const std::string left = NamesOf(argument);
      help += "  " + console.Styled(Style::kCyan, left);
      help += left.size() > width ? "\n" + std::string(width + 4, ' ') : std::string(width + 2 - left.size(), ' ');
      help += Folded(TextOf(argument), width + 4) + "\n";
    }
  }
  help += "\n" + console.Styled(Style::kBold, "Examples:") + "\n";
  for (const Example& example : command->Examples()) {
    help += "  " + example.line + "\n      " + Folded(example.text, 6) + "\n";
  }
  return help;
}

}  // namespace hgros::cli
