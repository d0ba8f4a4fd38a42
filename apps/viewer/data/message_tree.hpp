#pragma once

#include <google/protobuf/message.h>

#include <cstddef>
#include <set>
#include <string>
#include <vector>

namespace hgros::viewer {

/// A line of a message shown as a tree.
struct TreeRow {
  std::string path;  ///< As FieldPath reads it: names the row from message to message.
  std::string name;
  std::string value;  ///< Of numbers and texts; of lists and messages, what can be said in a few words.
  int depth = 0;
  bool folds = false;   ///< There is something below it.
  bool opened = false;  ///< And that follows.
  bool number = false;  ///< It can be plotted.
};

/// What is shown of a message.
struct TreeView {
  std::set<std::string> opened;  ///< Paths of the rows that are unfolded.
  std::size_t most_rows = 2000;
  std::size_t most_elements = 100;  ///< Of a list.
  std::size_t most_text = 200;      ///< Bytes of a text, of which control characters are shown as '?'.
};

/// The rows of a message, of whatever type; all its fields, also those that are not set. What is beyond the limits is
/// counted in a row of its own.
[[nodiscard]] std::vector<TreeRow> RowsOf(const google::protobuf::Message& message, const TreeView& view);

}  // namespace hgros::viewer
