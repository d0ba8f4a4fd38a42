#include "terminal/records.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "terminal/json.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kGap = 2;
constexpr std::size_t kMostCellColumns = 80;  // Of a cell that others follow.

void Write(Json& json, const Cell::Value& value) {
  std::visit(
      [&json](const auto& one) {
        using T = std::decay_t<decltype(one)>;
        if constexpr (std::is_same_v<T, std::monostate>) {
          json.Null();
        } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
          json.BeginList();
          for (const std::string& text : one) json.Value(text);
          json.EndList();
        } else if constexpr (std::is_same_v<T, JsonText>) {
          json.Raw(one.text);
        } else {
          json.Value(one);
        }
      },
      value);
}

}  // namespace

std::string Cell::Shown() const {
  if (!shown_.empty()) return shown_;
  return std::visit(
      [](const auto& one) -> std::string {
        using T = std::decay_t<decltype(one)>;
        if constexpr (std::is_same_v<T, std::monostate>) {
          return {};
        } else if constexpr (std::is_same_v<T, bool>) {
          return one ? "yes" : "no";
        } else if constexpr (std::is_same_v<T, std::string>) {
          return Visible(one);
        } else if constexpr (std::is_same_v<T, JsonText>) {
          return Visible(one.text);
        } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
          std::string joined;
          for (const std::string& text : one) joined += (joined.empty() ? "" : ", ") + Visible(text);
          return joined;
        } else {
          return fmt::format("{}", one);
        }
      },
      value_);
}

void WriteMembers(Json& json, const std::vector<Column>& columns, const std::vector<Cell>& cells) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (!columns[i].key.empty()) Write(json.Key(columns[i].key), cells[i].value());
  }
}

Records::Records(Console& console, OutputStyle style, std::vector<Column> columns)
    : console_(console), style_(style), columns_(std::move(columns)) {}

void Records::Add(std::vector<Cell> cells) {
  ++count_;
  cells.resize(columns_.size());
  if (style_.json) {
    Json json;
    WriteMembers(json.BeginObject(), columns_, cells);
    json.EndObject();
    return console_.Line(json.text());
  }
  rows_.push_back(std::move(cells));
}

void Records::End() {
  if (rows_.empty()) return;
  std::vector<std::vector<std::string>> shown(rows_.size());
  const bool first = widths_.empty();
  widths_.resize(columns_.size());
  const auto last = std::ranges::find_if(columns_.rbegin(), columns_.rend(),
                                         [](const Column& column) { return !column.heading.empty(); });
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (first) widths_[c] = std::max(columns_[c].least, ColumnsOf(columns_[c].heading));
    const bool any_length = style_.exact || (last != columns_.rend() && &columns_[c] == &*last);
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      std::string text = rows_[r][c].Shown();
      if (!any_length) text = Shortened(text, kMostCellColumns);
      widths_[c] = std::max(widths_[c], ColumnsOf(text));
      shown[r].push_back(std::move(text));
    }
  }
  const auto line = [&](const auto& text_of, const auto& style_of) {
    std::string text;
    std::size_t behind = 0;  // Spaces that are written only if another cell follows.
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (columns_[c].heading.empty()) continue;
      const std::string& cell = text_of(c);
      const std::size_t space = widths_[c] - ColumnsOf(cell);
      if (!cell.empty()) {
        text.append(behind + (columns_[c].right ? space : 0), ' ');
        text += console_.Styled(style_of(c), cell);
        behind = columns_[c].right ? kGap : space + kGap;
      } else {
        behind += widths_[c] + kGap;
      }
    }
    return text + "\n";
  };
  std::string table;
  if (first) {
    table = line([&](std::size_t c) -> const std::string& { return columns_[c].heading; },
                 [](std::size_t) { return Style::kBold; });
  }
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    table += line([&](std::size_t c) -> const std::string& { return shown[r][c]; },
                  [&](std::size_t c) { return rows_[r][c].style(); });
  }
  console_.Write(table);
  rows_.clear();
}

}  // namespace hgros::cli
