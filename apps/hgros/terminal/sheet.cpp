#include "terminal/sheet.hpp"

#include <algorithm>
#include <utility>

#include "terminal/json.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {

Sheet::Sheet(std::string kind, std::string name) : kind_(std::move(kind)), name_(std::move(name)) {}

void Sheet::Fact(std::string key, std::string label, Cell cell) {
  facts_.push_back({std::move(key), std::move(label)});
  cells_.push_back(std::move(cell));
}

void Sheet::Add(Table table) {
  for (std::vector<Cell>& row : table.rows) row.resize(table.columns.size());
  tables_.push_back(std::move(table));
}

void Sheet::WriteJson(Console& console) const {
  Json json;
  json.BeginObject().Member("kind", kind_).Member("name", name_);
  WriteMembers(json, facts_, cells_);
  for (const Table& table : tables_) {
    json.Key(table.key).BeginList();
    for (const std::vector<Cell>& row : table.rows) {
      WriteMembers(json.BeginObject(), table.columns, row);
      json.EndObject();
    }
    json.EndList();
  }
  json.EndObject();
  console.Line(json.text());
}

void Sheet::Write(Console& console, OutputStyle style) const {
  if (style.json) return WriteJson(console);
  std::size_t width = 0;
  for (const Column& fact : facts_) width = std::max(width, fact.heading.size());
  std::string text = kind_ + " " + console.Styled(Style::kBold, Visible(name_)) + "\n";
  for (std::size_t i = 0; i < facts_.size(); ++i) {
    const std::string shown = cells_[i].Shown();
    if (facts_[i].heading.empty() || shown.empty()) continue;
    text += "  " + console.Styled(Style::kCyan, facts_[i].heading);
    text += std::string(width + 2 - facts_[i].heading.size(), ' ') + console.Styled(cells_[i].style(), shown) + "\n";
  }
  console.Write(text);
  for (const Table& table : tables_) {
    if (table.rows.empty()) continue;
    console.Write("\n");
    std::vector<Column> columns = table.columns;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const auto has_none = [i](const std::vector<Cell>& row) {
        const std::string shown = row[i].Shown();
        return shown.empty() || shown == "-";
      };
      if (std::ranges::all_of(table.rows, has_none)) columns[i].heading.clear();
    }
    Records records(console, style, std::move(columns));
    for (const std::vector<Cell>& row : table.rows) records.Add(row);
    records.End();
  }
}

}  // namespace hgros::cli
