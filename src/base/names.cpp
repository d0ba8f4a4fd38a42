#include "hgros/base/names.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include "hgros/base/error.hpp"

namespace hgros {
namespace {

std::size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substituted, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row[b.size()];
}

// The length of the UTF-8 character that `text` begins with, 0 if it begins with none (RFC 3629: neither overlong
// forms nor surrogates nor anything past U+10FFFF).
std::size_t Utf8Length(std::string_view text) {
  const auto byte = [&](std::size_t i) -> unsigned {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0;
  };
  const auto continues = [&](std::size_t i) { return (byte(i) & 0xc0U) == 0x80U; };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  if (first < 0xc2) return 0;
  if (first < 0xe0) return continues(1) ? 2 : 0;
  const unsigned second = byte(1);
  if (first < 0xf0) {
    const bool refused = (first == 0xe0 && second < 0xa0) || (first == 0xed && second > 0x9f);
    return continues(1) && continues(2) && !refused ? 3 : 0;
  }
  const bool refused = (first == 0xf0 && second < 0x90) || (first == 0xf4 && second > 0x8f) || first > 0xf4;
  return continues(1) && continues(2) && continues(3) && !refused ? 4 : 0;
}

// The name for an error message: shortened, without control characters and invalid UTF-8.
std::string Shown(std::string_view name) {
  std::string text;
  while (!name.empty() && text.size() < 64) {
    const std::size_t length = Utf8Length(name);
    const auto c = static_cast<unsigned char>(name.front());
    if (length == 0 || c < 0x20 || c == 0x7f) {
      text += '?';
    } else {
      text += name.substr(0, length);
    }
    name.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return text;
}

}  // namespace

std::string ChannelNameFault(std::string_view name) {
  if (name.empty()) return "it is empty";
  if (name.size() > kMaxChannelNameLength) {
    return "it has " + std::to_string(name.size()) + " bytes, more than " + std::to_string(kMaxChannelNameLength);
  }
  for (std::size_t i = 0; i < name.size();) {
    const auto c = static_cast<unsigned char>(name[i]);
    if (c <= 0x20 || c == 0x7f) return "byte " + std::to_string(i + 1) + " is a space or control character";
    const std::size_t length = Utf8Length(name.substr(i));
    if (length == 0) return "byte " + std::to_string(i + 1) + " does not begin a UTF-8 character";
    i += length;
  }
  return {};
}

void RequireChannelName(std::string_view name) {
  const std::string fault = ChannelNameFault(name);
  if (fault.empty()) return;
  throw Error("The channel name \"" + Shown(name) + "\" cannot be used: " + fault + ".", {},
              "Use 1 to 200 bytes of visible UTF-8 text, such as \"robot1/scan\".");
}

std::string NearestName(std::string_view name, std::span<const std::string> candidates) {
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(name.size() < 4 ? 1 : 2, name.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = EditDistance(name, candidate);
    if (distance < best_distance && distance < std::max(name.size(), candidate.size())) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

}  // namespace hgros
