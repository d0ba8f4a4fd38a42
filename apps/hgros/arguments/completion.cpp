#include "arguments/completion.hpp"

#include <algorithm>
#include <memory>
#include <string_view>

namespace hgros::cli {
namespace {

std::vector<std::string> NamesIn(const Argument& argument) {
  std::vector<std::string> names;
  for (std::string_view rest = argument.names; !rest.empty();) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    names.emplace_back(rest.substr(0, comma));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return names;
}

const Argument* OptionIn(const Arguments& arguments, std::string_view name) {
  for (const Argument& argument : arguments.all()) {
    const std::vector<std::string> names = NamesIn(argument);
    if (!argument.positional() && std::ranges::find(names, name) != names.end()) return &argument;
  }
  return nullptr;
}

class Completer {
 public:
  explicit Completer(std::span<const CommandEntry> commands) : commands_(commands) {}

  // The names of commands; those of a family if `words` begins with it.
  void AddCommands(std::span<const std::string> words) {
    const CommandEntry* family = words.size() == 2 ? Find(words[0]) : nullptr;
    for (const CommandEntry& entry : commands_) {
      if (entry.hidden() || words.size() > 2 || (words.size() == 2 && (family == nullptr || !entry.IsIn(*family)))) {
        continue;
      }
      if (words.size() == 1 && entry.IsInAny()) continue;
      const std::size_t first = family == nullptr ? 0 : family->name.size() + 1;
      Add(words.back(), std::string(entry.name.substr(first)), std::string(entry.summary));
    }
  }

  void AddArguments(const CommandEntry& entry, std::span<const std::string> words) {
    const std::unique_ptr<Command> command = entry.make();
    Arguments arguments;
    command->Declare(arguments);
    const Argument* open = nullptr;  // The option whose value comes next.
    bool options_end = false;
    for (const std::string& word : words.first(words.size() - 1)) {
      if (open != nullptr) {
        completion_.options.insert(completion_.options.end(), {NamesIn(*open).back(), word});
        open = nullptr;
      } else if (word == "--" && !options_end) {
        options_end = true;
      } else if (options_end || !word.starts_with('-') || word == "-") {
        completion_.given.push_back(word);
      } else if (const Argument* option = OptionIn(arguments, word.substr(0, word.find('='))); option != nullptr) {
        const std::size_t equals = word.find('=');
        used_.push_back(option);
        if (option->value.empty()) continue;
        if (equals == std::string::npos) {
          open = option;
        } else {
          completion_.options.insert(completion_.options.end(), {NamesIn(*option).back(), word.substr(equals + 1)});
        }
      }
    }
    const std::string& last = words.back();
    const std::size_t equals = last.find('=');
    if (open != nullptr) {
      AddValues(*open, last);
    } else if (options_end || !last.starts_with('-')) {
      AddPositional(arguments, words);
    } else if (equals == std::string::npos) {
      AddOptions(arguments, last);
    } else if (const Argument* option = OptionIn(arguments, last.substr(0, equals)); option != nullptr) {
      completion_.before = last.substr(0, equals + 1);
      AddValues(*option, last.substr(equals + 1));
    }
  }

  void Add(std::string_view typed, const std::string& word, std::string text) {
    if (word.starts_with(typed)) completion_.words.push_back({completion_.before + word, std::move(text)});
  }
  [[nodiscard]] const CommandEntry* Find(std::string_view name) const {
    const auto found = std::ranges::find(commands_, name, &CommandEntry::name);
    return found == commands_.end() ? nullptr : &*found;
  }
  [[nodiscard]] Completion Take() && { return std::move(completion_); }

 private:
  void AddValues(const Argument& argument, const std::string& typed) {
    for (const std::string& choice : argument.choices) Add(typed, choice, "");
    completion_.typed = typed;
    completion_.kind = argument.kind;
    completion_.many = argument.many;
  }

  void AddPositional(const Arguments& arguments, std::span<const std::string> words) {
    std::vector<const Argument*> positional;
    for (const Argument& argument : arguments.all()) {
      if (argument.positional()) positional.push_back(&argument);
    }
    if (positional.empty()) return;
    std::size_t at = completion_.given.size();
    if (at >= positional.size() && !positional.back()->many) return;
    at = std::min(at, positional.size() - 1);
    if (positional[at]->kind != ValueKind::kCommand) {
      AddValues(*positional[at], words.back());
      if (at + 1 < positional.size()) completion_.next = positional[at + 1]->kind;
      return;
    }
    std::vector<std::string> name = completion_.given;
    name.push_back(words.back());
    AddCommands(name);
  }

  void AddOptions(const Arguments& arguments, const std::string& typed) {
    for (const Argument& argument : arguments.all()) {
      const bool used = std::ranges::find(used_, &argument) != used_.end();
      if (argument.positional() || (used && !argument.many)) continue;
      Add(typed, NamesIn(argument).back(), argument.text);
    }
    Add(typed, "--help", "Explain this command");
  }

  const std::span<const CommandEntry> commands_;
  Completion completion_;
  std::vector<const Argument*> used_;
};

}  // namespace

Completion CompletionOf(std::span<const std::string> words, std::span<const CommandEntry> commands) {
  Completer completer(commands);
  if (words.empty()) return {};
  const CommandEntry* entry = completer.Find(words.front());
  if (words.size() == 1) {
    completer.AddCommands(words);
    if (words.back().starts_with('-')) {
      completer.Add(words.back(), "--help", "List all commands");
      completer.Add(words.back(), "--version", "Tell the version");
    }
  } else if (entry != nullptr && !entry->family()) {
    completer.AddArguments(*entry, words.subspan(1));
  } else if (entry != nullptr && words.size() == 2) {
    completer.AddCommands(words);
  } else if (entry != nullptr) {
    entry = completer.Find(words[0] + " " + words[1]);
    if (entry != nullptr) completer.AddArguments(*entry, words.subspan(2));
  }
  return std::move(completer).Take();
}

}  // namespace hgros::cli
