#pragma once

#include <set>
#include <string>

#include "hgros/graph/node_options.hpp"

namespace hgros {

// Node names in the configuration that match no node: typing errors, or nodes of another process.
//
// Thread safety: none; the graph locks.
class UnmatchedOverrides {
 public:
  explicit UnmatchedOverrides(const NodeOverrides& overrides);

  void MarkMatched(const std::string& name);
  // One sentence with the unmatched names and similar node names. Empty if there are none or they were reported before.
  [[nodiscard]] std::string Report();

 private:
  static constexpr std::size_t kMostOthers = 256;  // Unnamed nodes that come and go always get new names.

  std::set<std::string> unmatched_;
  std::set<std::string> matched_;  // Names in the configuration that match a node.
  std::set<std::string> others_;   // Names of nodes without settings; kept while some name is untaken.
};

}  // namespace hgros
