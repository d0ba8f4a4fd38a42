#include "graph/unmatched_overrides.hpp"

#include <algorithm>
#include <utility>

#include "hgros/base/names.hpp"

namespace hgros {

UnmatchedOverrides::UnmatchedOverrides(const NodeOverrides& overrides) {
  for (const auto& [name, settings] : overrides) unmatched_.insert(name);
}

void UnmatchedOverrides::MarkMatched(const std::string& name) {
  if (unmatched_.empty()) return;
  if (auto here = unmatched_.extract(name); !here.empty()) {
    matched_.insert(std::move(here));
  } else if (!matched_.contains(name) && others_.size() < kMostOthers) {
    others_.insert(name);
  }
}

UnmatchedOverrides::Sentences UnmatchedOverrides::Report() {
  std::string misspelled;
  std::string others;
  const auto add = [](std::string& list, const std::string& text) { list += (list.empty() ? "" : ", ") + text; };
  for (auto name = unmatched_.begin(); name != unmatched_.end();) {
    const auto similar =
        std::ranges::find_if(others_, [&](const std::string& node) { return DifferByATypingError(node, *name); });
    if (similar == others_.end()) {
      if (said_.insert(*name).second) add(others, "\"" + *name + "\"");
      ++name;
      continue;
    }
    add(misspelled, "\"" + *name + "\" (did you mean \"" + *similar + "\"?)");
    name = unmatched_.erase(name);
  }
  const auto sentence = [](const std::string& list) {
    return list.empty()
               ? list
               : "The configuration sets data_graph: nodes for names that no node of this process has so far: " + list +
                     ".";
  };
  return {sentence(misspelled), sentence(others)};
}

}  // namespace hgros
