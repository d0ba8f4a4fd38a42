#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hgros/session/known_channel.hpp"
#include "viewer/data/channel_rates.hpp"

namespace hgros::viewer {

/// A channel as a line of a table.
struct ChannelLine {
  std::string name;
  std::string schema;
  std::string publishers;  ///< Their programs; how often each, if more than once.
  std::string subscribers;
  std::optional<ChannelRate::Figures> figures;  ///< None: it is not measured.
  std::string conflict = {};                    ///< TypeConflict.
};

enum class ChannelColumn { kName, kSchema, kPublishers, kSubscribers, kRate, kBandwidth, kLatency, kDrops, kAge };

[[nodiscard]] ChannelLine MakeChannelLine(const KnownChannel& channel);
/// Those without a value of that column come last in either direction; equal ones by name.
void SortLines(std::vector<ChannelLine>& lines, ChannelColumn column, bool descending);

}  // namespace hgros::viewer
