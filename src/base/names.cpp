#include "hgros/base/names.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/base/readable_text.hpp"

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
    if (length > 1 && !IsReadable(name.substr(i, length))) {
      return "byte " + std::to_string(i + 1) + " begins a control character or one that changes the direction of text";
    }
    i += length;
  }
  return {};
}

void RequireChannelName(std::string_view name) {
  const std::string fault = ChannelNameFault(name);
  if (fault.empty()) return;
  throw Error("The channel name \"" + Readable(name, 64) + "\" cannot be used: " + fault + ".", {},
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
