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
  // Sentences with the unmatched names that were not reported before; empty if there are none.
  struct Sentences {
    std::string misspelled;  // Names that are similar to a node's.
    std::string others;
  };
  [[nodiscard]] Sentences Report();

 private:
  static constexpr std::size_t kMostOthers = 256;  // Unnamed nodes that come and go always get new names.

  std::set<std::string> unmatched_;
  std::set<std::string> matched_;  // Names in the configuration that match a node.
  std::set<std::string> others_;   // Names of nodes without settings; kept while some name is untaken.
  std::set<std::string> said_;     // Unmatched names without a similar one that were reported.
};

}  // namespace hgros
