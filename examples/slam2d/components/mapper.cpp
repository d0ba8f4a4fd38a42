#include "mapper.hpp"

#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "../app/channels.hpp"
#include "../app/fail.hpp"

namespace slam2d {
namespace {

// Compares the options that cannot change once a map is begun: those of this mapper and those of the saved map.
void RequireSame(const MapOptions& ours, const MapOptions& theirs) {
  const auto require = [](const char* name, double our_value, double their_value) {
    if (our_value == their_value) return;
    std::ostringstream text;
    text << "The saved map has " << name << " = " << their_value << ", but here it is " << our_value
         << ". Give both mappers the same value.";
    throw std::invalid_argument(text.str());
  };
  require("cell_size_m", ours.cell_size_m, theirs.cell_size_m);
  require("min_value", ours.min_value, theirs.min_value);
  require("max_value", ours.max_value, theirs.max_value);
}

// Every cell of the map.
MapDelta Whole(const OccupancyMap& map) {
  MapDelta all;
  all.version = map.version();
  for (const auto& [index, tile] : map.tiles()) {
    const auto first = static_cast<std::uint32_t>(all.cells.size());
    for (std::size_t cell = 0; cell < tile.size(); ++cell) {
      if (tile[cell] == 0) continue;
      all.cells.push_back(static_cast<std::uint16_t>(cell));
      all.values.push_back(tile[cell]);
    }
    all.tiles.push_back({index, first, static_cast<std::uint32_t>(all.cells.size()) - first});
  }
  return all;
}

}  // namespace

MapperComponent::MapperComponent(hgros::Context& context)
    : context_(context),
      tuned_(context),
      updates_(context.Advertise<msg::MapUpdate>(kNextChannel)),
      states_(context.Advertise<msg::MapState>(kMapState, {.latched = 1})),
      mapper_(tuned_.Now()) {
  context.FromAny<msg::MatchedScan>(
      kPreChannel, hgros::Invoke::kSerial,
      FailOnException<msg::MatchedScan>(context, [this](const msg::MatchedScan& message) { TakeMatch(message); }),
      {.name = {}, .queue = hgros::Queue::KeepAll(kLoopDepth), .executor = {}});
  context.FromAny<msg::Done>(kDone, hgros::Invoke::kSerial, [this](const msg::Done&) { context_.Finish(); });
}

void MapperComponent::Activate() { RequireOk(states_(Save()), "The map"); }

msg::MapState MapperComponent::Save() {
  const std::scoped_lock lock(mutex_);
  msg::MapState state;
  state.set_next_scan(next_scan_);
  Write(Whole(mapper_.map()), *state.mutable_map());
  Write(mapper_.map().options(), *state.mutable_map()->mutable_layout());
  if (mapper_.T_map_drawn()) Write(*mapper_.T_map_drawn(), *state.mutable_drawn());
  if (next_scan_ > 0) *state.mutable_last() = last_;
  return state;
}

void MapperComponent::Restore(const msg::MapState& state) {
  const std::scoped_lock lock(mutex_);
  OccupancyMap map(mapper_.map().options());
  RequireSame(map.options(), Read(state.map().layout()));
  map.Apply(Read(state.map()));
  std::optional<Pose2> drawn;
  if (state.has_drawn()) drawn = Read(state.drawn());
  mapper_ = Mapper(std::move(map), drawn);
  next_scan_ = state.next_scan();
  last_ = state.last();
  context_.log().Write(hgros::LogLevel::kInfo, "It goes on with scan " + std::to_string(next_scan_) + ".");
}

void MapperComponent::TakeMatch(const msg::MatchedScan& message) {
  msg::MapUpdate update;
  if (message.scan().end_of_log()) {
    update.set_version(message.scan().sequence());
    update.set_end_of_log(true);
  } else {
    update = Draw(message);
  }
  RequireOk(updates_(update), "A map update");
}

msg::MapUpdate MapperComponent::Draw(const msg::MatchedScan& message) {
  const std::scoped_lock lock(mutex_);
  const std::uint64_t scan = message.scan().sequence();
  if (scan + 1 == next_scan_) return Answer();  // The matcher has no answer yet: perhaps it was lost.
  if (scan < next_scan_) {
    throw std::runtime_error("Scan " + std::to_string(scan) + " arrived, but scan " + std::to_string(next_scan_) +
                             " is next. Start the mapper again to begin a new map.");
  }
  if (scan > next_scan_) {
    context_.log().Write(hgros::LogLevel::kWarning, "The scans from " + std::to_string(next_scan_) + " to " +
                                                        std::to_string(scan - 1) + " are not in this map.");
  }
  if (const auto options = tuned_.News()) mapper_.SetOptions(*options);
  msg::MapUpdate update;
  Write(mapper_.Add(Read(message.scan()), Read(message.match())), update);
  Write(mapper_.map().options(), *update.mutable_layout());
  *update.mutable_match() = message.match();
  *update.mutable_odometry() = message.scan().odometry();
  next_scan_ = scan + 1;
  ++drawn_;
  last_ = update;
  return Answer();
}

msg::MapUpdate MapperComponent::Answer() const {
  msg::MapUpdate update = last_;
  if (drawn_ > 1) return update;
  update.clear_tile_x();
  update.clear_tile_y();
  update.clear_tile_count();
  Write(Whole(mapper_.map()), update);
  update.set_whole(true);
  return update;
}

}  // namespace slam2d

HGROS_COMPONENT(slam2d::MapperComponent, "slam2d/Mapper")
