#include "arguments/manual.hpp"

#include <algorithm>
#include <memory>

#include "arguments/help.hpp"

namespace hgros::cli {
namespace {

// Text that roff shows as it is.
std::string Plain(std::string_view text) {
  std::string plain;
  if (text.starts_with('.') || text.starts_with('\'')) plain = "\\&";
  for (const char c : text) {
    switch (c) {
      case '\\': plain += "\\e"; break;
      case '-': plain += "\\-"; break;
      case '`':
      case '\'': plain += c == '`' ? "\\(ga" : "\\(aq"; break;
      case '~': plain += "\\(ti"; break;
      default: plain += c;
    }
  }
  return plain;
}

std::string Item(std::string_view name, std::string_view text) {
  return ".TP\n\\fB" + Plain(name) + "\\fR\n" + Plain(text) + ".\n";
}

std::string Head(const std::string& name, std::string_view version, std::string_view summary) {
  std::string capitals = name;
  std::ranges::transform(capitals, capitals.begin(), [](char c) { return c >= 'a' && c <= 'z' ? char(c - 32) : c; });
  return ".TH \"" + Plain(capitals) + "\" 1 \"\" \"hgros " + Plain(version) + "\" \"HyperGraph ROS\"\n.SH NAME\n" +
         Plain(name) + " \\- " + Plain(summary) + "\n.SH SYNOPSIS\n";
}

std::string Tail(const std::string& see_also) {
  return ".SH EXIT STATUS\n" + Item("0", "Done") +
         Item("1", "What was asked for is not there, was refused, or something is wrong") +
         Item("2", "The command line, or a file that it names, is wrong") + Item("3", "The time of --timeout is over") +
         ".SH ENVIRONMENT\n" + Item("HGROS_DOMAIN", "The domain without --domain") +
         Item("NO_COLOR", "If set, the output has no colors") + ".SH SEE ALSO\n" + see_also + "\n";
}

std::string Reference(std::string_view page) { return "\\fB" + Plain(page) + "\\fR(1)"; }

// One item for each command, and references to their pages.
std::string Listed(std::span<const CommandEntry> commands, const CommandEntry* family, std::string& references) {
  std::string list;
  for (const CommandEntry& entry : commands) {
    if (entry.hidden() || (family == nullptr ? entry.IsInAny() : !entry.IsIn(*family))) continue;
    list += Item("hgros " + std::string(entry.name), entry.summary);
    references += (references.empty() ? "" : ", ") + Reference(ManualName(entry));
  }
  return list;
}

}  // namespace

std::string ManualName(const CommandEntry& entry) {
  std::string name = "hgros-" + std::string(entry.name);
  std::ranges::replace(name, ' ', '-');
  return name;
}

std::string ManualOfAll(std::string_view version, std::span<const CommandEntry> commands) {
  std::string references;
  const std::string list = Listed(commands, nullptr, references);
  return Head("hgros", version, "see, check, measure and steer running robots") +
         ".B hgros\nCOMMAND [ARGUMENTS] [OPTIONS]\n.SH DESCRIPTION\n" +
         Plain(
             "Each command meets the sessions of this user on this host in the same domain, and those that --connect "
             "or --config name. Tables are for people; with --json each command writes one JSON object per line.") +
         "\n.SH COMMANDS\n" + list + Tail(references);
}

std::string ManualOf(std::string_view version, const CommandEntry& entry, std::span<const CommandEntry> commands) {
  std::string page = Head(ManualName(entry), version, entry.summary);
  if (entry.family()) {
    std::string references = Reference("hgros") + ", ";
    std::string members;
    const std::string list = Listed(commands, &entry, members);
    return page + ".B hgros " + Plain(entry.name) + "\nCOMMAND [ARGUMENTS] [OPTIONS]\n.SH COMMANDS\n" + list +
           Tail(references + members);
  }
  const std::unique_ptr<Command> command = entry.make();
  Arguments arguments;
  command->Declare(arguments);
  page += ".B " + Plain(UsageOf(entry, arguments)) + "\n.SH DESCRIPTION\n" + Plain(command->Description()) + "\n";
  for (const bool positional : {true, false}) {
    bool first = true;
    for (const Argument& argument : arguments.all()) {
      if (argument.positional() != positional) continue;
      if (first) page += positional ? ".SH ARGUMENTS\n" : ".SH OPTIONS\n";
      first = false;
      page += Item(NamesOf(argument), TextOf(argument));
    }
  }
  page += ".SH EXAMPLES\n";
  for (const Example& example : command->Examples()) {
    page += ".TP\n\\fB" + Plain(example.line) + "\\fR\n" + Plain(example.text) + "\n";
  }
  return page + Tail(Reference("hgros"));
}

}  // namespace hgros::cli
