#include "arguments/arguments.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include <CLI/CLI.hpp>

#include "hgros/base/names.hpp"

namespace hgros::cli {
namespace {

std::string Quoted(const std::string& text) { return "\"" + text + "\""; }

// Before CLI11 reads them, so that a misspelled option is the first fault and its value none. CLI11 also takes values
// for flags, and throws errors of other kinds for some of them.
void RequireKnownOptions(std::span<const std::string> words, const std::vector<Argument>& known) {
  std::vector<std::string> names;
  std::vector<std::string> flags;
  for (const Argument& argument : known) {
    for (std::string rest = argument.names; !argument.positional() && !rest.empty();) {
      const std::size_t comma = rest.find(',');
      names.push_back(rest.substr(0, comma));
      if (argument.value.empty()) flags.push_back(names.back());
      rest = comma == std::string::npos ? "" : rest.substr(comma + 1);
    }
  }
  for (const std::string& word : words) {
    if (word == "--") return;
    const std::string name = word.substr(0, word.find('='));
    if (!name.starts_with("--")) continue;
    if (name != word && std::ranges::find(flags, name) != flags.end()) {
      throw UsageError(name + " takes no value. Write " + name + " alone.");
    }
    if (std::ranges::find(names, name) != names.end()) continue;
    const std::string nearest = NearestName(name, names);
    throw UsageError(name + " is not an option." + (nearest.empty() ? "" : " Did you mean " + nearest + "?"));
  }
}

// CLI11 takes [1, 2] apart, takes -1.5 for an option, and means something by {}, %% and ++. All are values here. This
// character in front of every value hides them.
constexpr char kHidden = '\x01';

bool IsOption(const std::string& word) {
  return word.size() > 1 && word[0] == '-' && word[1] != '.' && (word[1] < '0' || word[1] > '9');
}

std::vector<std::string> Hidden(std::span<const std::string> words) {
  std::vector<std::string> hidden;
  bool options_end = false;
  for (std::string word : words) {
    if (options_end || !IsOption(word)) {
      word.insert(0, 1, kHidden);
    } else if (const std::size_t equals = word.find('='); word.starts_with("--") && equals != std::string::npos) {
      word.insert(equals + 1, 1, kHidden);
    }
    options_end = options_end || word == "--";
    hidden.push_back(std::move(word));
  }
  return hidden;
}

std::vector<std::string> Shown(std::vector<std::string> words) {
  for (std::string& word : words) {
    if (word.starts_with(kHidden)) word.erase(0, 1);
  }
  return words;
}

// CLI11's errors as sentences of ours.
std::string SentenceFor(const CLI::Error& error) {
  std::string text = error.what();
  std::erase(text, kHidden);
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    const std::string word = text.substr(text.rfind(' ') + 1);
    return word.starts_with('-') ? word + " is not an option." : Quoted(word) + " is one argument too many.";
  }
  if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
    return text.substr(0, text.rfind(" is ")) + " is missing.";
  }
  return text + (text.ends_with('.') ? "" : ".");
}

// Nothing that has a name or a file has an empty one.
bool MayBeEmpty(ValueKind kind) { return kind == ValueKind::kText || kind == ValueKind::kParam; }

}  // namespace

void Arguments::Add(Argument argument, Setter setter) {
  all_.push_back(std::move(argument));
  setters_.push_back(std::move(setter));
}

void Arguments::Flag(std::string names, bool& variable, std::string text) {
  Add({std::move(names), "", std::move(text)}, [&variable](const std::vector<std::string>&) {
    variable = true;
    return std::string();
  });
}

void Arguments::Option(std::string names, std::string value, std::string& variable, std::string text, ValueKind kind) {
  Add({std::move(names), std::move(value), std::move(text), kind}, [&variable](const std::vector<std::string>& given) {
    variable = given.back();
    return std::string();
  });
}

void Arguments::Option(std::string names, std::string value, std::vector<std::string>& variable, std::string text,
                       ValueKind kind) {
  Argument argument{std::move(names), std::move(value), std::move(text), kind};
  argument.many = true;
  Add(std::move(argument), [&variable](const std::vector<std::string>& given) {
    variable = given;
    return std::string();
  });
}

void Arguments::Option(std::string names, std::string value, std::optional<double>& variable, std::string text,
                       bool also_zero) {
  Add({std::move(names), std::move(value), std::move(text)}, [&variable,
                                                              also_zero](const std::vector<std::string>& given) {
    char* end = nullptr;
    const double number = std::strtod(given.back().c_str(), &end);
    if (given.back().empty() || *end != '\0' || !std::isfinite(number) || number < 0 || (number == 0 && !also_zero)) {
      return Quoted(given.back()) + (also_zero ? " is not a number from zero on." : " is not a number above zero.");
    }
    variable = number;
    return std::string();
  });
}

void Arguments::Option(std::string names, std::string value, std::optional<std::uint64_t>& variable, std::string text) {
  Add({std::move(names), std::move(value), std::move(text)}, [&variable](const std::vector<std::string>& given) {
    const std::string& digits = given.back();
    if (digits.empty() || digits.size() > 18 || digits.find_first_not_of("0123456789") != std::string::npos ||
        std::stoull(digits) == 0) {
      return Quoted(digits) + " is not a whole number above zero.";
    }
    variable = std::stoull(digits);
    return std::string();
  });
}

void Arguments::Count(std::optional<std::uint64_t>& count, std::string once_text, std::string count_text) {
  Add({"--once", "", std::move(once_text)}, [&count](const std::vector<std::string>&) {
    if (count.value_or(1) != 1) return std::string("It contradicts --count. Leave out one of them.");
    count = 1;
    return std::string();
  });
  Option("-n,--count", "N", count, std::move(count_text));
  setters_.back() = [&count, set = setters_.back()](const std::vector<std::string>& given) {
    const bool once = count.has_value();
    std::string fault = set(given);
    if (fault.empty() && once && count != 1) fault = "It contradicts --once. Leave out one of them.";
    return fault;
  };
}

void Arguments::Choice(std::string names, std::string& variable, std::vector<std::string> choices, std::string text) {
  Argument argument{std::move(names), "", std::move(text), ValueKind::kText, std::move(choices)};
  if (!argument.positional()) argument.value = "WHAT";
  Add(argument, [&variable, choices = argument.choices](const std::vector<std::string>& given) {
    if (std::ranges::find(choices, given.back()) != choices.end()) {
      variable = given.back();
      return std::string();
    }
    std::string all;
    for (const std::string& choice : choices) all += (all.empty() ? "" : ", ") + choice;
    return Quoted(given.back()) + " is not one of: " + all + ".";
  });
}

void Arguments::Positional(Argument argument, std::string& variable) {
  Add(std::move(argument), [&variable](const std::vector<std::string>& given) {
    variable = given.back();
    return std::string();
  });
}

void Arguments::Positional(Argument argument, std::vector<std::string>& variable) {
  argument.many = true;
  Add(std::move(argument), [&variable](const std::vector<std::string>& given) {
    variable = given;
    return std::string();
  });
}

void Arguments::Parse(std::span<const std::string> words) const {
  RequireKnownOptions(words, all_);
  CLI::App app;
  app.set_help_flag();
  for (std::size_t i = 0; i < all_.size(); ++i) {
    const Argument& argument = all_[i];
    const Setter& setter = setters_[i];
    const auto set = [&setter, &argument](const std::vector<std::string>& given) {
      if (!MayBeEmpty(argument.kind) && std::ranges::find(given, "") != given.end()) {
        throw UsageError(argument.names + " is empty." +
                         (argument.required ? " Give it a value." : " Leave it out, or give it a value."));
      }
      const std::string fault = setter(given);
      if (!fault.empty()) throw UsageError(argument.names + ": " + fault);
    };
    if (!argument.positional() && argument.value.empty()) {
      app.add_flag_function(argument.names, [set](std::int64_t) { set({}); });
      continue;
    }
    CLI::Option* option = app.add_option_function<std::vector<std::string>>(
        argument.names, [set](const std::vector<std::string>& given) { set(Shown(given)); });
    option->required(argument.required);
    if (argument.many) {
      option->expected(argument.required ? 1 : 0, CLI::detail::expected_max_vector_size);
      // An option takes one value each time; otherwise it would take the positional arguments behind it.
      if (!argument.positional()) {
        option->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)->allow_extra_args(false);
      }
    } else {
      option->expected(1)->allow_extra_args(false);
      if (!argument.positional()) option->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    }
  }
  try {
    std::vector<std::string> hidden = Hidden(words);
    std::ranges::reverse(hidden);
    app.parse(std::move(hidden));
  } catch (const CLI::Error& error) {
    throw UsageError(SentenceFor(error));
  }
}

}  // namespace hgros::cli
