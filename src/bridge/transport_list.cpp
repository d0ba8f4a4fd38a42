#include "hgros/bridge/transport_list.hpp"

#include <algorithm>
#include <utility>

#include "hgros/base/error.hpp"

namespace hgros {

TransportList::TransportList(std::vector<TransportEntry> entries) : entries_(std::move(entries)) {
  if (entries_.size() > TransportSet::kMost) {
    throw Error("A session has " + std::to_string(entries_.size()) + " transports; it can have " +
                    std::to_string(TransportSet::kMost) + ".",
                {}, "Remove some.");
  }
  std::ranges::stable_sort(entries_, {}, &TransportEntry::cost);
  for (TransportIndex i = 0; i < entries_.size(); ++i) {
    if (Find(entries_[i].key) != i) {
      throw Error("Two transports have the key \"" + entries_[i].key + "\".", {}, "Give one of them another key.");
    }
    all_.Add(i);
    if (entries_[i].reach == TransportReach::kHost) on_host_.Add(i);
  }
}

std::optional<TransportIndex> TransportList::Find(std::string_view key) const {
  const auto found = std::ranges::find(entries_, key, &TransportEntry::key);
  if (found == entries_.end()) return std::nullopt;
  return static_cast<TransportIndex>(found - entries_.begin());
}

TransportSet TransportList::SetOf(const TransportKeys& keys) const {
  if (!keys) return all_;
  TransportSet set;
  for (const std::string& key : *keys) {
    if (const auto transport = Find(key)) set.Add(*transport);
  }
  return set;
}

std::string TransportList::NamesOf(TransportSet transports) const {
  std::string names;
  for (TransportIndex i = 0; i < size(); ++i) {
    if (transports.Has(i)) names += (names.empty() ? "" : " and ") + name(i);
  }
  return names;
}

}  // namespace hgros
