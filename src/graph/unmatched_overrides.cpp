#include "graph/unmatched_overrides.hpp"

#include <utility>
#include <vector>

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

std::string UnmatchedOverrides::Report() {
  if (unmatched_.empty()) return {};
  const std::vector<std::string> others(others_.begin(), others_.end());
  std::string list;
  for (const std::string& name : std::exchange(unmatched_, {})) {
    const std::string nearest = NearestName(name, others);
    list += (list.empty() ? "\"" : ", \"") + name + "\"" +
            (nearest.empty() ? std::string() : " (did you mean \"" + nearest + "\"?)");
  }
  return "The configuration sets data_graph: nodes for names that no node of this process has so far: " + list + ".";
}

}  // namespace hgros
