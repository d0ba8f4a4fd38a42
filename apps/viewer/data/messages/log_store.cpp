#include "viewer/data/messages/log_store.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

#include "viewer/data/cut_text.hpp"
#include "viewer/data/stamp.hpp"

namespace hgros::viewer {
namespace {

bool SameLetter(char a, char b) {
  return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
}

bool Contains(std::string_view text, std::string_view part) {
  return std::search(text.begin(), text.end(), part.begin(), part.end(), SameLetter) != text.end();
}

}  // namespace

void LogStore::Add(const foxglove::Log& log) {
  // An unknown level counts as none.
  const int number = static_cast<int>(log.level());
  const bool known = number >= 0 && number < static_cast<int>(kLevels);
  Line line;
  line.stamp = StampOf(log.timestamp());
  line.level = known ? log.level() : foxglove::Log::UNKNOWN;
  line.source = CutText(log.name());
  line.text = CutText(log.message());
  if (!log.file().empty()) line.place = std::string(CutText(log.file())) + ":" + std::to_string(log.line());
  ++counts_[static_cast<std::size_t>(line.level)];
  if (sources_.size() < kMaxSources || sources_.contains(line.source)) ++sources_[line.source];
  if (!lines_.empty()) {
    Line& last = lines_.back();
    if (last.level == line.level && last.source == line.source && last.text == line.text && last.place == line.place) {
      ++last.repeats;
      last.stamp = line.stamp;
      return;
    }
  }
  lines_.push_back(std::move(line));
  while (lines_.size() > max_lines_) {
    lines_.pop_front();
    ++forgotten_;
  }
}

void LogStore::Clear() {
  lines_.clear();
  sources_.clear();
  counts_ = {};
  forgotten_ = 0;
}

std::uint64_t LogStore::count(foxglove::Log::Level level) const noexcept {
  const auto at = static_cast<std::size_t>(level);
  return at < counts_.size() ? counts_[at] : 0;
}

std::vector<std::size_t> LogStore::Find(const Filter& filter, std::size_t most) const {
  std::vector<std::size_t> found;
  for (std::size_t i = lines_.size(); i-- > 0 && found.size() < most;) {
    const Line& line = lines_[i];
    if (line.level < filter.least || (!filter.source.empty() && line.source != filter.source)) continue;
    if (Contains(line.text, filter.part)) found.push_back(i);
  }
  std::ranges::reverse(found);
  return found;
}

}  // namespace hgros::viewer
