#include "top/top_list.hpp"

#include <algorithm>
#include <cctype>
#include <optional>
#include <utility>

namespace hgros::cli {
namespace {

constexpr std::size_t kLeastText = 12;
constexpr std::size_t kBetweenColumns = 2;

std::string InLowerCase(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool IsText(const Cell& cell) {
  return std::holds_alternative<std::string>(cell.value()) ||
         std::holds_alternative<std::vector<std::string>>(cell.value());
}

// Numbers compare with each other; what is unknown has none.
std::optional<double> NumberOf(const Cell& cell) {
  return std::visit(
      [](const auto& value) -> std::optional<double> {
        if constexpr (std::is_arithmetic_v<std::decay_t<decltype(value)>>) return static_cast<double>(value);
        return std::nullopt;
      },
      cell.value());
}

bool Contains(const TopRow& row, const std::vector<Column>& columns, const std::string& text) {
  for (std::size_t i = 0; i < row.cells.size(); ++i) {
    const bool searched = IsText(row.cells[i]) && !columns[i].heading.empty();
    if (searched && InLowerCase(row.cells[i].Shown()).find(text) != std::string::npos) return true;
  }
  return false;
}

}  // namespace

TopList::TopList(TopKind kind) : kind_(kind), sorted_by_(FirstSortOf(kind)) {}

void TopList::Show(std::vector<TopRow> rows) {
  rows_ = std::move(rows);
  Arrange();
}

void TopList::Filter(const std::string& text) {
  filter_ = InLowerCase(text);
  Arrange();
}

void TopList::Arrange() {
  shown_.clear();
  for (const TopRow& row : rows_) {
    if (filter_.empty() || Contains(row, columns(), filter_)) shown_.push_back(&row);
  }
  const auto comes_before = [this](const TopRow* left, const TopRow* right) {
    const Cell& a = left->cells[sorted_by_];
    const Cell& b = right->cells[sorted_by_];
    if (IsText(a) && IsText(b)) {
      const auto* text = std::get_if<std::string>(&a.value());
      const auto* other = std::get_if<std::string>(&b.value());
      const int order = text != nullptr && other != nullptr ? text->compare(*other) : a.Shown().compare(b.Shown());
      return reversed_ ? order > 0 : order < 0;
    }
    const std::optional<double> x = NumberOf(a);
    const std::optional<double> y = NumberOf(b);
    if (!x || !y) return x.has_value() && !y.has_value();  // What is unknown comes last.
    return reversed_ ? *x < *y : *x > *y;
  };
  std::ranges::stable_sort(shown_, comes_before);
  const auto found = selected_id_.empty() ? shown_.end() : std::ranges::find(shown_, selected_id_, &TopRow::id);
  if (found != shown_.end()) {
    selected_ = static_cast<std::size_t>(found - shown_.begin());
  } else if (selected_id_.empty()) {
    selected_ = 0;
  }
  Move(0);
}

bool TopList::SortBy(std::string_view key) {
  const auto found = std::ranges::find(columns(), key, &Column::key);
  if (found == columns().end()) return false;
  sorted_by_ = static_cast<std::size_t>(found - columns().begin());
  reversed_ = false;
  Arrange();
  return true;
}

void TopList::SortByNeighbor(int step) {
  const std::size_t count = columns().size();
  const std::size_t forward = step > 0 ? 1 : count - 1;
  do {
    sorted_by_ = (sorted_by_ + forward) % count;
  } while (columns()[sorted_by_].heading.empty());
  reversed_ = false;
  Arrange();
}

void TopList::Reverse() {
  reversed_ = !reversed_;
  Arrange();
}

const TopRow* TopList::Selected() const { return selected_ < shown_.size() ? shown_[selected_] : nullptr; }

void TopList::Move(std::ptrdiff_t rows) {
  const std::ptrdiff_t last = static_cast<std::ptrdiff_t>(shown_.size()) - 1;
  const std::ptrdiff_t place = static_cast<std::ptrdiff_t>(selected_) + rows;
  selected_ = static_cast<std::size_t>(std::max<std::ptrdiff_t>(std::min(place, last), 0));
  if (rows != 0) selected_id_ = selected_ == 0 || shown_.empty() ? "" : shown_[selected_]->id;
}

std::size_t TopList::FirstInWindow(std::size_t height) {
  const std::size_t rows = shown_.size();
  first_ = std::min(first_, rows > height ? rows - height : 0);
  if (selected_ < first_) first_ = selected_;
  if (height > 0 && selected_ >= first_ + height) first_ = selected_ - height + 1;
  return first_;
}

std::vector<std::size_t> ColumnWidths(const std::vector<Column>& columns, std::vector<std::size_t> wanted,
                                      std::size_t width) {
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (columns[i].heading.empty()) wanted[i] = 0;
  }
  const auto least = [&](std::size_t i) { return columns[i].right ? wanted[i] : std::min(wanted[i], kLeastText); };
  const auto too_wide = [&](const auto& width_of) {
    std::size_t sum = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i) sum += wanted[i] == 0 ? 0 : width_of(i) + kBetweenColumns;
    return sum > width + kBetweenColumns;
  };
  for (std::size_t last = wanted.size(); last-- > 1 && too_wide(least);) wanted[last] = 0;
  for (std::size_t& one : wanted) one = std::min(one, std::max(width, kLeastText));
  while (too_wide([&](std::size_t i) { return wanted[i]; })) {
    std::size_t widest = wanted.size();
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      if (wanted[i] > least(i) && (widest == wanted.size() || wanted[i] > wanted[widest])) widest = i;
    }
    if (widest == wanted.size()) break;
    --wanted[widest];
  }
  if (!wanted.empty()) wanted.front() = std::min(wanted.front(), width);
  return wanted;
}

}  // namespace hgros::cli
