#include "component/number_gaps.hpp"

#include <algorithm>

namespace hgros {

void NumberGaps::Note(std::uint64_t before, std::uint64_t number) {
  if (number <= before) return Fill(number);
  if (before == 0 || number == before + 1) return;
  if (gaps_.size() == kMost) gaps_.erase(gaps_.begin());
  gaps_.push_back({before + 1, number - 1});
}

bool NumberGaps::Has(std::uint64_t number) const noexcept {
  return std::ranges::any_of(gaps_, [&](const Gap& gap) { return gap.first <= number && number <= gap.last; });
}

void NumberGaps::Fill(std::uint64_t number) {
  const auto gap =
      std::ranges::find_if(gaps_, [&](const Gap& one) { return one.first <= number && number <= one.last; });
  if (gap == gaps_.end()) return;
  const Gap behind{number + 1, gap->last};
  gap->last = number - 1;
  const bool any_before = gap->first <= gap->last;
  const bool any_behind = behind.first <= behind.last;
  if (!any_before) {
    if (!any_behind) {
      gaps_.erase(gap);
    } else {
      *gap = behind;
    }
  } else if (any_behind) {
    gaps_.insert(gap + 1, behind);
    if (gaps_.size() > kMost) gaps_.erase(gaps_.begin());
  }
}

}  // namespace hgros
