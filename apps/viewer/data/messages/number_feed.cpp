#include "viewer/data/messages/number_feed.hpp"

#include <algorithm>

namespace hgros::viewer {

void NumberFeed::Resolve(Watched& watched) const {
  watched.field.reset();
  watched.fault.clear();
  if (type_) watched.field = FieldPath::Parse(watched.path, type_->descriptor(), watched.fault);
}

void NumberFeed::Add(const RawMessage& message, Time at) {
  const std::scoped_lock lock(mutex_);
  std::shared_ptr<const DynamicSchema> type = schemas_.Find(message.schema);
  fault_ = schemas_.fault();
  if (type != type_) {
    type_ = std::move(type);
    for (Watched& watched : watched_) Resolve(watched);
  }
  if (!type_ || watched_.empty()) return;
  const auto parsed = type_->Read(message.data.bytes);
  if (!parsed) {
    fault_ = "The last message cannot be read: its bytes are not a " + message.schema->type_name +
             ", or it needs too much memory.";
    return;
  }
  for (Watched& watched : watched_) {
    if (!watched.field) continue;
    if (const auto number = watched.field->Read(*parsed)) watched.numbers.Add(at, *number);
  }
}

const NumberFeed::Watched* NumberFeed::Find(const std::string& path) const {
  const auto found = std::ranges::find(watched_, path, &Watched::path);
  return found == watched_.end() ? nullptr : &*found;
}

void NumberFeed::Watch(const std::string& path) {
  const std::scoped_lock lock(mutex_);
  if (Find(path) != nullptr) return;
  watched_.push_back({path, std::nullopt, {}, NumberSeries(kept_, kMostValues)});
  Resolve(watched_.back());
}

void NumberFeed::Forget(const std::string& path) {
  const std::scoped_lock lock(mutex_);
  const auto found = std::ranges::find(watched_, path, &Watched::path);
  if (found == watched_.end()) return;
  // The limits of a series are constant, so a series cannot be assigned. The vector is rebuilt instead.
  std::vector<Watched> others;
  for (Watched& watched : watched_) {
    if (watched.path != path) others.push_back(std::move(watched));
  }
  watched_.swap(others);
}

void NumberFeed::Clear() {
  const std::scoped_lock lock(mutex_);
  for (Watched& watched : watched_) watched.numbers.Clear();
}

NumberFeed::View NumberFeed::Look(const std::string& path, Time from, Time to, std::size_t columns) const {
  const std::scoped_lock lock(mutex_);
  View view;
  const Watched* const watched = Find(path);
  if (watched == nullptr) return view;
  view.fault = fault_.empty() ? watched->fault : fault_;
  view.columns = watched->numbers.Columns(from, to, columns);
  if (watched->numbers.size() > 0) view.newest = watched->numbers.values().back().value;
  return view;
}

std::optional<Time> NumberFeed::Newest(const std::string& path) const {
  const std::scoped_lock lock(mutex_);
  const Watched* const watched = Find(path);
  if (watched == nullptr || watched->numbers.size() == 0) return std::nullopt;
  return watched->numbers.values().back().at;
}

std::vector<std::string> NumberFeed::Paths() const {
  const std::scoped_lock lock(mutex_);
  return type_ ? NumberPaths(type_->descriptor(), kMostPaths) : std::vector<std::string>();
}

std::string NumberFeed::fault() const {
  const std::scoped_lock lock(mutex_);
  return fault_;
}

}  // namespace hgros::viewer
