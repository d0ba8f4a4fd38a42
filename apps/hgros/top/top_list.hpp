#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "terminal/records.hpp"
#include "top/activity.hpp"

namespace hgros::cli {

/// The rows of a list as the user wants them: filtered, sorted, one of them selected, and those that are in the window.
///
/// Threading: one thread.
class TopList {
 public:
  explicit TopList(TopKind kind);

  [[nodiscard]] TopKind kind() const noexcept { return kind_; }
  [[nodiscard]] const std::vector<Column>& columns() const { return TopColumns(kind_); }
  /// Takes the newest rows. A row that the user has selected stays selected, wherever it is then; the first row does
  /// not.
  void Show(std::vector<TopRow> rows);
  /// Only rows with this text in a column of text, whatever its case. Empty: all.
  void Filter(const std::string& text);

  /// The column by which the rows are sorted. Texts begin with the smallest, numbers with the largest.
  [[nodiscard]] std::size_t sorted_by() const noexcept { return sorted_by_; }
  /// False if there is no such column.
  bool SortBy(std::string_view key);
  /// The next (1) or previous (-1) column that is shown.
  void SortByNeighbor(int step);
  void Reverse();

  /// Those that the filter accepts, in order.
  [[nodiscard]] const std::vector<const TopRow*>& shown() const noexcept { return shown_; }
  [[nodiscard]] std::size_t all() const noexcept { return rows_.size(); }
  /// Null if there are no rows.
  [[nodiscard]] const TopRow* Selected() const;
  [[nodiscard]] std::size_t selected() const noexcept { return selected_; }
  /// Moves the selection by so many rows, and stays among them.
  void Move(std::ptrdiff_t rows);
  /// The first row of a window of `height` rows in which the selected one is.
  [[nodiscard]] std::size_t FirstInWindow(std::size_t height);

 private:
  void Arrange();

  const TopKind kind_;
  std::vector<TopRow> rows_;          // By name.
  std::vector<const TopRow*> shown_;  // Into rows_.
  std::string filter_;                // In lower case.
  std::size_t sorted_by_;
  bool reversed_ = false;
  std::size_t selected_ = 0;  // In shown_.
  std::string selected_id_;   // Empty: the first row, whichever it is.
  std::size_t first_ = 0;
};

/// Widths for the columns of a table that is at most `width` wide with two spaces between columns: those of texts
/// become narrower, then columns at the end are left out (0), as are those without a heading.
[[nodiscard]] std::vector<std::size_t> ColumnWidths(const std::vector<Column>& columns, std::vector<std::size_t> wanted,
                                                    std::size_t width);

}  // namespace hgros::cli
