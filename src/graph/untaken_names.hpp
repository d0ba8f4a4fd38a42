#pragma once

#include <set>
#include <string>

#include "hgros/graph/node_options.hpp"

namespace hgros {

// The node names that configuration has settings for and that no node has taken: slips of the pen, or nodes that run
// elsewhere.
//
// Thread safety: none, the graph locks.
class UntakenNames {
 public:
  explicit UntakenNames(const NodeOverrides& overrides);

  void Take(const std::string& name);
  // One sentence with the names that were perhaps meant; empty if there is nothing to say, or it was said before.
  [[nodiscard]] std::string Say();

 private:
  static constexpr std::size_t kMostOthers = 256;  // Unnamed nodes that come and go get ever new names.

  std::set<std::string> untaken_;
  std::set<std::string> taken_;   // The others that have settings.
  std::set<std::string> others_;  // Names of nodes without settings; kept while some name is untaken.
};

}  // namespace hgros
