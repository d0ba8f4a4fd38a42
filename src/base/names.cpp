#include "hgros/base/names.hpp"

#include <algorithm>
#include <cctype>
#include <numeric>
#include <utility>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/base/readable_text.hpp"

namespace hgros {
namespace {

// The number of letters to insert, remove, replace or swap with the next one, to make one text of the other. Looks no
// further once that is known to be at least `limit`, and then returns `limit`.
class EditDistance {
 public:
  std::size_t operator()(std::string_view a, std::string_view b, std::size_t limit) {
    if (std::max(a.size(), b.size()) - std::min(a.size(), b.size()) >= limit) return limit;
    above_.resize(b.size() + 1);
    std::iota(above_.begin(), above_.end(), std::size_t{0});
    std::size_t least_above = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      row_.assign(1, i + 1);
      std::size_t least = i + 1;
      for (std::size_t j = 0; j < b.size(); ++j) {
        std::size_t one = std::min({above_[j] + (a[i] == b[j] ? 0 : 1), row_[j] + 1, above_[j + 1] + 1});
        if (i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j]) one = std::min(one, before_[j - 1] + 1);
        row_.push_back(one);
        least = std::min(least, one);
      }
      if (least >= limit && least_above + 1 >= limit) return limit;
      least_above = least;
      std::swap(before_, above_);
      std::swap(above_, row_);
    }
    return std::min(above_.back(), limit);
  }

 private:
  std::vector<std::size_t> before_;  // The row above above_.
  std::vector<std::size_t> above_;
  std::vector<std::size_t> row_;
};

// Lower case, without slashes at the beginning.
std::string Plain(std::string_view name) {
  while (name.starts_with('/')) name.remove_prefix(1);
  std::string plain(name);
  std::ranges::transform(plain, plain.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return plain;
}

template <typename Unwanted>
std::string Without(std::string text, Unwanted unwanted) {
  std::erase_if(text, unwanted);
  return text;
}

bool JoinsWords(char c) { return c == '_' || c == '-'; }

std::vector<std::string> WordsOf(const std::string& name) {
  std::vector<std::string> words(1);
  for (const char c : name) {
    if (JoinsWords(c) || c == '/') {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  return words;
}

bool IsMistyped(const std::string& a, const std::string& b) {
  const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  const std::size_t letters = std::min(a.size(), b.size());
  if (letters < 4 || a.front() != b.front() || Without(a, is_digit) == Without(b, is_digit)) return false;
  const std::size_t most = letters >= 8 && a.back() == b.back() ? 2 : 1;
  return EditDistance()(a, b, most + 1) <= most;
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
  EditDistance distance_of;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = distance_of(name, candidate, best_distance);
    if (distance < best_distance && distance < std::max(name.size(), candidate.size())) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

bool DifferByATypingError(std::string_view a, std::string_view b) {
  const std::string left = Plain(a);
  const std::string right = Plain(b);
  if (a == b) return false;
  if (Without(left, JoinsWords) == Without(right, JoinsWords)) return true;
  const std::vector<std::string> words = WordsOf(left);
  const std::vector<std::string> others = WordsOf(right);
  if (words.size() != others.size()) return false;
  const auto [one, other] = std::ranges::mismatch(words, others);
  if (one == words.end()) return false;  // Only the signs between the words differ.
  return std::equal(one + 1, words.end(), other + 1) && IsMistyped(*one, *other);
}

}  // namespace hgros
