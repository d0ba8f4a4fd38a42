#pragma once

#include <string>
#include <vector>

#include "terminal/records.hpp"

namespace hgros::cli {

/// All about one thing: facts, and tables of what belongs to it. One JSON object, with a list for each table.
///
/// Threading: one thread.
class Sheet {
 public:
  /// `kind`: what it is, such as "channel".
  Sheet(std::string kind, std::string name);

  /// Facts that are empty are shown in JSON only. `label`: empty: only in JSON.
  void Fact(std::string key, std::string label, Cell cell);
  struct Table {
    std::string key;
    std::vector<Column> columns;
    std::vector<std::vector<Cell>> rows;
  };
  /// Tables without rows are shown in JSON only, as are columns that are empty or "-" in every row. Cells that a row
  /// lacks at its end are empty.
  void Add(Table table);

  void Write(Console& console, OutputStyle style) const;

 private:
  void WriteJson(Console& console) const;

  const std::string kind_;
  const std::string name_;
  std::vector<Column> facts_;
  std::vector<Cell> cells_;  // One for each fact.
  std::vector<Table> tables_;
};

}  // namespace hgros::cli
