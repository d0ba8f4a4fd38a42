#include "hgros/base/error.hpp"

#include <charconv>
#include <system_error>
#include <vector>

#include "hgros/base/readable_text.hpp"

namespace hgros {
namespace {

std::string Join(std::string_view what, std::string_view where, std::string_view mend) {
  std::string text;
  if (!where.empty()) text.append(where).append(": ");
  text.append(what);
  if (!mend.empty()) text.append(" ").append(mend);
  return text;
}

}  // namespace

std::string FilePosition::ToString() const {
  std::string text = file;
  if (line > 0) text += ":" + std::to_string(line);
  if (line > 0 && column > 0) text += ":" + std::to_string(column);
  return text;
}

FilePosition FilePosition::From(std::string_view text) {
  std::vector<int> numbers;
  while (numbers.size() < 2) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string_view::npos) break;
    const std::string_view digits = text.substr(colon + 1);
    int number = 0;
    const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (fault != std::errc() || end != digits.data() + digits.size()) break;
    numbers.insert(numbers.begin(), number);
    text = text.substr(0, colon);
  }
  return {std::string(text), numbers.empty() ? 0 : numbers[0], numbers.size() < 2 ? 0 : numbers[1]};
}

Error::Error(std::string_view what, std::string_view where, std::string_view mend)
    : std::runtime_error(Join(AsUtf8(what), AsUtf8(where), AsUtf8(mend))), where_(AsUtf8(where)), mend_(AsUtf8(mend)) {}

std::string Error::sentence() const {
  std::string text = what();
  if (!mend_.empty()) text.resize(text.size() - mend_.size() - 1);
  if (!where_.empty()) text.erase(0, where_.size() + 2);
  return text;
}

ConfigError::ConfigError(std::string_view what, const FilePosition& position, std::string_view mend)
    : Error(what, position.ToString(), mend) {}

}  // namespace hgros
