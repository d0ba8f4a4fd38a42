#include "yaml/variables.hpp"

#include <algorithm>
#include <cstdlib>

#include "hgros/yaml/quoted.hpp"
#include "yaml/text_places.hpp"

namespace hgros::yaml {
namespace {

constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_";
constexpr std::string_view kDigits = "0123456789";

// Two characters that no text should have: Unicode keeps them free for uses inside a program.
constexpr std::string_view kOpen = "\uFDD0";
constexpr std::string_view kClose = "\uFDD1";

bool IsName(std::string_view text) {
  return !text.empty() && kDigits.find(text.front()) == std::string_view::npos &&
         std::ranges::all_of(text, [](char letter) {
           return kLetters.find(letter) != std::string_view::npos || kDigits.find(letter) != std::string_view::npos;
         });
}

// `inside` is what is between the braces.
std::string ValueOf(std::string_view inside, const Variables& variables, const FilePosition& position) {
  const std::size_t separator = inside.find(":-");
  const std::string name(inside.substr(0, separator));
  if (!IsName(name)) {
    throw ConfigError(Quoted("${" + std::string(inside) + "}") + " is not the name of a variable.", position,
                      "Write ${NAME} or ${NAME:-default}; for the characters themselves, $${.");
  }
  if (const std::optional<std::string> value = variables(name);
      value && (separator == std::string_view::npos || !value->empty())) {
    TextPlaces places(*value);
    RequireCleanText(places, "the variable " + name);
    return *value;
  }
  if (separator != std::string_view::npos) return std::string(inside.substr(separator + 2));
  throw ConfigError("The variable " + name + " is not set.", position,
                    "Set it, or write a default: ${" + name + ":-default}.");
}

}  // namespace

std::optional<std::string> EnvironmentVariable(const std::string& name) {
  const char* value = std::getenv(name.c_str());
  return value == nullptr ? std::nullopt : std::optional<std::string>(value);
}

std::string WithoutBraces(std::string_view text) {
  std::string without;
  while (true) {
    const std::size_t begin = text.find("${");
    const std::size_t end = text.find_first_of("}\n", begin);
    if (end == std::string_view::npos) return without.append(text);
    if (text[end] == '\n') {
      without += text.substr(0, end);
      text.remove_prefix(end);
      continue;
    }
    without.append(text.substr(0, begin + 1)).append(kOpen);
    without.append(text.substr(begin + 2, end - begin - 2)).append(kClose);
    text.remove_prefix(end + 1);
  }
}

std::string WithBraces(std::string_view value) {
  std::string with;
  while (!value.empty()) {
    if (value.starts_with(kOpen) || value.starts_with(kClose)) {
      with += value.starts_with(kOpen) ? '{' : '}';
      value.remove_prefix(kOpen.size());
    } else {
      with += value.front();
      value.remove_prefix(1);
    }
  }
  return with;
}

std::string WithVariables(std::string_view text, const Variables& variables, const FilePosition& position) {
  std::string replaced;
  while (true) {
    const std::size_t begin = text.find("${");
    replaced += text.substr(0, begin);
    if (begin == std::string_view::npos) return replaced;
    text.remove_prefix(begin + 2);
    if (replaced.ends_with('$')) {
      replaced += '{';
      continue;
    }
    const std::size_t end = text.find('}');
    if (end == std::string_view::npos) {
      throw ConfigError("A variable that begins with \"${\" is not closed.", position, "Close it with \"}\".");
    }
    replaced += ValueOf(text.substr(0, end), variables, position);
    text.remove_prefix(end + 1);
  }
}

}  // namespace hgros::yaml
