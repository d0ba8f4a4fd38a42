#include "graph/untaken_names.hpp"

#include <utility>
#include <vector>

#include "hgros/base/names.hpp"

namespace hgros {

UntakenNames::UntakenNames(const NodeOverrides& overrides) {
  for (const auto& [name, settings] : overrides) untaken_.insert(name);
}

void UntakenNames::Take(const std::string& name) {
  if (untaken_.empty()) return;
  if (auto here = untaken_.extract(name); !here.empty()) {
    taken_.insert(std::move(here));
  } else if (!taken_.contains(name) && others_.size() < kMostOthers) {
    others_.insert(name);
  }
}

std::string UntakenNames::Say() {
  if (untaken_.empty()) return {};
  const std::vector<std::string> others(others_.begin(), others_.end());
  std::string list;
  for (const std::string& name : std::exchange(untaken_, {})) {
    const std::string nearest = NearestName(name, others);
    list += (list.empty() ? "\"" : ", \"") + name + "\"" +
            (nearest.empty() ? std::string() : " (did you mean \"" + nearest + "\"?)");
  }
  return "The configuration has settings under data_graph: nodes for names that no node of this process has taken so "
         "far: " +
         list + ".";
}

}  // namespace hgros
