#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hgros/bridge/known_channel.hpp"
#include "viewer/data/channels/channel_rates.hpp"

namespace hgros::viewer {

/// A channel as a line of a table.
struct ChannelLine {
  std::string name;
  std::string schema;
  std::string publishers;  ///< Their programs, each with its count if there are several.
  std::string subscribers;
  std::optional<ChannelRate::Figures> figures;  ///< None: it is not measured.
  std::string conflict = {};                    ///< TypeConflict.
};

enum class ChannelColumn { kName, kSchema, kPublishers, kSubscribers, kRate, kBandwidth, kLatency, kDrops, kAge };

[[nodiscard]] ChannelLine MakeChannelLine(const KnownChannel& channel);
/// Rows without a value in that column come last in both directions. Equal rows are sorted by name.
void SortLines(std::vector<ChannelLine>& lines, ChannelColumn column, bool descending);

}  // namespace hgros::viewer
