#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "terminal/console.hpp"

namespace hgros::cli {

class Json;

/// A value that is JSON already.
struct JsonText {
  std::string text;
};

/// A value of a record: what JSON gets, and what people see.
class Cell {
 public:
  using Value = std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string,
                             std::vector<std::string>, JsonText>;

  Cell() = default;                                                 // NOLINT: an empty cell; null in JSON
  Cell(std::string text) : value_(std::move(text)) {}               // NOLINT(google-explicit-constructor)
  Cell(const char* text) : value_(std::string(text)) {}             // NOLINT(google-explicit-constructor)
  Cell(bool value) : value_(value) {}                               // NOLINT(google-explicit-constructor)
  Cell(std::uint64_t value) : value_(value) {}                      // NOLINT(google-explicit-constructor)
  Cell(std::int64_t value) : value_(value) {}                       // NOLINT(google-explicit-constructor)
  Cell(std::vector<std::string> list) : value_(std::move(list)) {}  // NOLINT(google-explicit-constructor)
  /// A number with its text for people, such as "10.0 Hz".
  Cell(double value, std::string shown) : value_(value), shown_(std::move(shown)) {}
  Cell(bool value, std::string shown) : value_(value), shown_(std::move(shown)) {}
  Cell(std::uint64_t value, std::string shown) : value_(value), shown_(std::move(shown)) {}
  Cell(std::int64_t value, std::string shown) : value_(value), shown_(std::move(shown)) {}

  /// `shown` is visible.
  Cell(std::string value, std::string shown) : value_(std::move(value)), shown_(std::move(shown)) {}
  Cell(JsonText value, std::string shown) : value_(std::move(value)), shown_(std::move(shown)) {}

  [[nodiscard]] Cell In(Style style) && {
    style_ = style;
    return std::move(*this);
  }
  [[nodiscard]] const Value& value() const noexcept { return value_; }
  [[nodiscard]] Style style() const noexcept { return style_; }
  /// For people; visible. Empty: nothing is known, or the list is empty.
  [[nodiscard]] std::string Shown() const;

 private:
  Value value_;
  std::string shown_;
  Style style_ = Style::kPlain;
};

struct Column {
  std::string key;        ///< In JSON, with its unit, such as rate_hz; empty: only in the table.
  std::string heading;    ///< Of the table; empty: only in JSON.
  bool right = false;     ///< Numbers are aligned on the right.
  std::size_t least = 0;  ///< Its width in characters at least, for records that are added after End().
};

/// Columns or cells, one after the other.
template <class T>
requires std::same_as<T, Column> || std::same_as<T, Cell>
[[nodiscard]] std::vector<T> operator+(std::vector<T> first, std::vector<T> second) {
  for (T& one : second) first.push_back(std::move(one));
  return first;
}

/// The cells as members of the JSON object that was begun.
void WriteMembers(Json& json, const std::vector<Column>& columns, const std::vector<Cell>& cells);

/// Records with the same columns: an aligned table when all are known, or one JSON object per line at once. Except in
/// the last column and with --exact, long texts of a table are shortened.
///
/// Threading: one thread.
class Records {
 public:
  Records(Console& console, OutputStyle style, std::vector<Column> columns);

  /// One cell per column; those that are lacking at the end are empty.
  void Add(std::vector<Cell> cells);
  /// Writes the table. Without records: nothing. More records may follow, and another End(): they continue the table.
  void End();
  [[nodiscard]] std::size_t size() const noexcept { return count_; }

 private:
  Console& console_;
  const OutputStyle style_;
  const std::vector<Column> columns_;
  std::vector<std::vector<Cell>> rows_;
  std::vector<std::size_t> widths_;  // Of the table so far; empty: it has not begun.
  std::size_t count_ = 0;
};

}  // namespace hgros::cli
