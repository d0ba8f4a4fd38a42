#include "export/unit_text.hpp"

#include <algorithm>

#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

std::string HexByte(char letter) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  const auto byte = static_cast<unsigned char>(letter);
  return {'\\', 'x', kDigits[byte >> 4U], kDigits[byte & 15U]};
}

bool IsAlphanumeric(char letter) {
  return (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') || (letter >= '0' && letter <= '9');
}

std::string Doubled(std::string_view text, std::string_view letters) {
  std::string doubled;
  for (const char letter : text) {
    doubled += letter;
    if (letters.find(letter) != std::string_view::npos) doubled += letter;
  }
  return doubled;
}

std::string Quoted(std::string_view text) {
  constexpr std::string_view kPlain = "%+,-./:=@_$";
  const auto plain = [&](char letter) {
    return IsAlphanumeric(letter) || kPlain.find(letter) != std::string_view::npos;
  };
  if (!text.empty() && std::ranges::all_of(text, plain)) return std::string(text);
  std::string quoted = "\"";
  for (const char letter : text) {
    if (letter == '"' || letter == '\\') {
      quoted += '\\';
      quoted += letter;
    } else if (static_cast<unsigned char>(letter) < 0x20 || letter == 0x7f) {
      quoted += HexByte(letter);
    } else {
      quoted += letter;
    }
  }
  return quoted + '"';
}

}  // namespace

std::string EscapedRobotName(std::string_view name) {
  constexpr std::string_view kEnd = "-end";  // As in the name of the target that ends a robot.
  const std::size_t last = name.ends_with(kEnd) ? name.size() - kEnd.size() : name.size() - 1;
  std::string escaped;
  for (std::size_t begin = 0; begin < name.size();) {
    const std::size_t hyphen = std::min(name.find('-', begin), name.size());
    escaped += EscapedUnitName(name.substr(begin, hyphen - begin));
    if (hyphen < name.size()) escaped += hyphen == 0 || hyphen >= last ? "\\x2d" : "-";
    begin = hyphen + 1;
  }
  return escaped;
}

std::string EscapedUnitName(std::string_view name) {
  std::string escaped;
  for (const char letter : name) {
    const bool fits = IsAlphanumeric(letter) || letter == ':' || letter == '_' || (letter == '.' && !escaped.empty());
    if (fits) {
      escaped += letter;
    } else {
      escaped += HexByte(letter);
    }
  }
  return escaped;
}

std::string UnitWord(std::string_view text) { return Quoted(Doubled(text, "%")); }

// ";" alone, which begins another command, is quoted, too.
std::string CommandWord(std::string_view text) { return Quoted(Doubled(text, "%$")); }

std::string CommandLine(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& one : words) line += (line.empty() ? "" : " ") + CommandWord(one);
  return line;
}

std::string UnitSentence(std::string_view text) {
  std::string sentence = Doubled(Visible(text), "%");
  if (sentence.ends_with('\\')) sentence += '.';  // Otherwise the next line would belong to it.
  return sentence;
}

}  // namespace hgros::cli
