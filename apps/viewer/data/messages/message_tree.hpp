#pragma once

#include <google/protobuf/message.h>

#include <cstddef>
#include <set>
#include <string>
#include <vector>

namespace hgros::viewer {

/// A line of a message shown as a tree.
struct TreeRow {
  std::string path;  ///< As FieldPath reads it. Identifies the row in all messages.
  std::string name;
  std::string value;  ///< The value of a number or text; a short description of a list or message.
  int depth = 0;
  bool folds = false;   ///< It has rows below it.
  bool opened = false;  ///< The rows below it follow.
  bool number = false;  ///< It can be plotted.
};

/// Which rows of a message are shown.
struct TreeView {
  std::set<std::string> opened;  ///< Paths of the rows that are unfolded.
  std::size_t most_rows = 2000;
  std::size_t most_elements = 100;  ///< Shown elements of a list.
  std::size_t most_text = 200;      ///< Shown bytes of a text. Control characters are shown as '?'.
};

/// The rows of a message of any type, with all its fields, including those that are not set. An extra row counts what
/// exceeds the limits.
[[nodiscard]] std::vector<TreeRow> RowsOf(const google::protobuf::Message& message, const TreeView& view);

}  // namespace hgros::viewer
