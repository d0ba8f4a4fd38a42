#include "viewer/data/channels/channel_table.hpp"

#include <algorithm>
#include <map>

#include "viewer/data/channels/type_conflict.hpp"

namespace hgros::viewer {
namespace {

std::string Programs(const std::vector<ChannelUser>& users) {
  std::map<std::string, std::size_t> counts;
  for (const ChannelUser& user : users) ++counts[user.process.empty() ? "(no name)" : user.process];
  std::string text;
  for (const auto& [program, count] : counts) {
    text += (text.empty() ? "" : ", ") + program + (count > 1 ? " x " + std::to_string(count) : "");
  }
  return text;
}

const std::string* TextIn(const ChannelLine& line, ChannelColumn column) {
  switch (column) {
    case ChannelColumn::kName: return &line.name;
    case ChannelColumn::kSchema: return &line.schema;
    case ChannelColumn::kPublishers: return &line.publishers;
    case ChannelColumn::kSubscribers: return &line.subscribers;
    default: return nullptr;
  }
}

std::optional<double> NumberIn(const ChannelLine& line, ChannelColumn column) {
  if (!line.figures) return std::nullopt;
  const ChannelRate::Figures& figures = *line.figures;
  const auto ns = [](const std::optional<std::chrono::nanoseconds>& duration) {
    return duration ? std::optional(static_cast<double>(duration->count())) : std::nullopt;
  };
  switch (column) {
    case ChannelColumn::kRate: return figures.messages_per_second;
    case ChannelColumn::kBandwidth: return figures.bytes_per_second;
    case ChannelColumn::kLatency: return ns(figures.latency);
    case ChannelColumn::kDrops: return static_cast<double>(figures.missed);
    case ChannelColumn::kAge: return ns(figures.silence);
    default: return std::nullopt;
  }
}

}  // namespace

ChannelLine MakeChannelLine(const KnownChannel& channel) {
  return {channel.name, channel.type_name,    Programs(channel.publishers), Programs(channel.subscribers),
          std::nullopt, TypeConflict(channel)};
}

void SortLines(std::vector<ChannelLine>& lines, ChannelColumn column, bool descending) {
  std::ranges::sort(lines, [&](const ChannelLine& a, const ChannelLine& b) {
    if (const std::string* const text = TextIn(a, column)) {
      const std::string& other = *TextIn(b, column);
      if (text->empty() != other.empty()) return other.empty();
      if (*text != other) return descending ? other < *text : *text < other;
      return a.name < b.name;
    }
    const auto left = NumberIn(a, column);
    const auto right = NumberIn(b, column);
    if (left.has_value() != right.has_value()) return left.has_value();
    if (left && *left != *right) return descending ? *right < *left : *left < *right;
    return a.name < b.name;
  });
}

}  // namespace hgros::viewer
