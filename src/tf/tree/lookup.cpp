#include <algorithm>
#include <array>
#include <limits>
#include <span>

#include "tf/tree/edge_reading.hpp"
#include "tf/tree/tree_core.hpp"

namespace hgros::tf {
namespace {

using Way = std::span<const Frame* const>;

constexpr std::int64_t kAlways = std::numeric_limits<std::int64_t>::max();

constexpr std::size_t kBlock = 16;  // Number of edges that are read before they are multiplied.

// T_ancestor_frame along the edges from a frame up to its ancestor, from the newest transform of each. `stamp` stays
// kAlways if all edges are static. False if the moving edges do not all have the same newest stamp; this is `stamp`,
// unless that is kAlways.
bool ComposeNewest(Way edges, std::uint64_t* versions, Pose& pose, std::int64_t& stamp) {
  std::array<Pose, kBlock> poses;
  pose = IdentityPose();
  for (std::size_t end = edges.size(); end > 0;) {
    const std::size_t count = std::min(end, kBlock);
    for (std::size_t i = 0; i < count; ++i) {
      const Frame& edge = *edges[--end];
      std::uint64_t version = 0;
      const std::int64_t newest = ReadNewest(edge, poses[i], version);
      if (versions != nullptr) versions[end] = version;
      if (edge.is_static || newest == stamp) continue;
      if (stamp != kAlways) return false;
      stamp = newest;
    }
    const Pose part = Product(poses.data(), count);
    pose = count == edges.size() ? part : pose * part;
  }
  return true;
}

// The same at one time; false with the fault in `outcome`.
bool ComposeAt(Way edges, std::int64_t stamp, Pose& pose, Outcome& outcome) {
  std::array<Pose, kBlock> poses;
  pose = IdentityPose();
  for (std::size_t end = edges.size(); end > 0;) {
    const std::size_t count = std::min(end, kBlock);
    for (std::size_t i = 0; i < count; ++i) {
      const Frame* edge = edges[--end];
      const Reading reading = ReadAt(*edge, stamp, poses[i]);
      if (reading == Reading::kFound) continue;
      outcome.fault = reading == Reading::kTooOld ? TransformFault::kTooOld : TransformFault::kTooNew;
      outcome.edge = edge;
      outcome.wanted = stamp;
      return false;
    }
    const Pose part = Product(poses.data(), count);
    pose = count == edges.size() ? part : pose * part;
  }
  return true;
}

std::int64_t EarliestNewest(Way edges, std::uint64_t* versions, std::int64_t earliest) {
  for (std::size_t i = 0; i < edges.size(); ++i) {
    Pose pose;
    std::uint64_t version = 0;
    const std::int64_t newest = ReadNewest(*edges[i], pose, version);
    if (versions != nullptr) versions[i] = version;
    if (!edges[i]->is_static) earliest = std::min(earliest, newest);
  }
  return earliest;
}

// The moving edge whose newest stamp is the earliest; there is at least one moving edge.
const Frame* EarliestEdge(Way from_source, Way from_target) {
  const Frame* found = nullptr;
  std::int64_t earliest = kAlways;
  for (const Way edges : {from_source, from_target}) {
    for (const Frame* edge : edges) {
      Pose pose;
      std::uint64_t version = 0;
      const std::int64_t newest = ReadNewest(*edge, pose, version);
      if (edge->is_static || (found != nullptr && newest >= earliest)) continue;
      found = edge;
      earliest = newest;
    }
  }
  return found;
}

// T_target_source from both frames' poses in their common ancestor.
Pose Joined(const Pose& target, const Pose& source, bool target_is_ancestor) {
  return target_is_ancestor ? source : Inverse(target) * source;
}

bool Compose(Way from_source, Way from_target, std::int64_t stamp, Outcome& outcome) {
  Pose source;
  Pose target;
  if (!ComposeAt(from_source, stamp, source, outcome) || !ComposeAt(from_target, stamp, target, outcome)) return false;
  outcome.pose = Joined(target, source, from_target.empty());
  outcome.stamp = stamp;
  return true;
}

// Unless `versions` is null, it gets the versions of the source's and then of the target's edges, not later than the
// transforms that were read.
void ComposeLatest(Way from_source, Way from_target, std::uint64_t* versions, Outcome& outcome) {
  std::uint64_t* target_versions = versions == nullptr ? nullptr : versions + from_source.size();
  Pose source;
  Pose target;
  std::int64_t stamp = kAlways;
  if (ComposeNewest(from_source, versions, source, stamp) &&
      ComposeNewest(from_target, target_versions, target, stamp)) {
    outcome.pose = Joined(target, source, from_target.empty());
    outcome.is_static = stamp == kAlways;
    outcome.stamp = outcome.is_static ? 0 : stamp;
    return;
  }
  // Between the two reads of an edge, its writer may have gone so far that this time is no longer in the buffer; then
  // it is no longer the latest one. A reader that cannot keep up for long gets the fault.
  const auto earliest = [&] {
    return EarliestNewest(from_target, target_versions, EarliestNewest(from_source, versions, kAlways));
  };
  stamp = earliest();
  for (int tries = 0; tries < 8; ++tries) {
    outcome.fault = TransformFault::kNone;
    if (Compose(from_source, from_target, stamp, outcome)) return;
    const std::int64_t now = earliest();
    if (now == stamp) break;
    stamp = now;
  }
  if (outcome.fault == TransformFault::kTooOld) outcome.lagging = EarliestEdge(from_source, from_target);
}

}  // namespace

bool TreeCore::FindWay(FrameId target, FrameId source, Memo*& memo, Route& route, Outcome& outcome) const {
  outcome.target = target;
  outcome.source = source;
  for (const FrameId id : {target, source}) {
    const Frame* frame = frames_.At(id);
    if (frame != nullptr && frame->known.load(std::memory_order_acquire)) continue;
    outcome.fault = TransformFault::kUnknownFrame;
    outcome.unknown = id;
    return false;
  }
  if (!route.Find(*frames_.At(target), *frames_.At(source))) {
    outcome.fault = TransformFault::kNotConnected;
    outcome.target_root = route.target_root;
    outcome.source_root = route.source_root;
    return false;
  }
  const Way from_source = route.from_source.edges();
  const Way from_target = route.from_target.edges();
  if (from_source.size() + from_target.size() > Memo::kMostEdges) {
    memo = nullptr;
    return true;
  }
  memo->tree = number_;
  memo->target = target;
  memo->source = source;
  memo->has_latest = false;
  memo->source_edges = static_cast<std::uint16_t>(from_source.size());
  memo->all_edges = static_cast<std::uint16_t>(from_source.size() + from_target.size());
  std::copy(from_target.begin(), from_target.end(),
            std::copy(from_source.begin(), from_source.end(), memo->edges.begin()));
  return true;
}

void TreeCore::LookupLatest(FrameId target, FrameId source, Outcome& outcome) const {
  Memo* memo = &Memo::PlaceFor(number_, target, source);
  if (memo->Is(number_, target, source)) {
    if (memo->LatestHolds()) {
      outcome.pose = memo->latest;
      outcome.stamp = memo->latest_stamp;
      outcome.is_static = memo->latest_is_static;
      return;
    }
  } else {
    Route route;
    if (!FindWay(target, source, memo, route, outcome)) return;
    if (memo == nullptr) {
      ComposeLatest(route.from_source.edges(), route.from_target.edges(), nullptr, outcome);
      return;
    }
  }
  memo->has_latest = false;
  ComposeLatest(memo->FromSource(), memo->FromTarget(), memo->versions.data(), outcome);
  if (outcome.fault == TransformFault::kNone) {
    memo->latest = outcome.pose;
    memo->latest_stamp = outcome.stamp;
    memo->latest_is_static = outcome.is_static;
    memo->has_latest = true;
  } else {
    outcome.target = target;
    outcome.source = source;
  }
}

void TreeCore::LookupAt(FrameId target, FrameId source, std::int64_t stamp, Outcome& outcome) const {
  Memo* memo = &Memo::PlaceFor(number_, target, source);
  bool found = false;
  if (memo->Is(number_, target, source)) {
    found = Compose(memo->FromSource(), memo->FromTarget(), stamp, outcome);
  } else {
    Route route;
    if (!FindWay(target, source, memo, route, outcome)) return;
    found = Compose(route.from_source.edges(), route.from_target.edges(), stamp, outcome);
  }
  if (!found) {
    outcome.target = target;
    outcome.source = source;
  }
}

void TreeCore::Lookup(const TransformQuery& query, Outcome& outcome) const {
  const auto find = [this](FrameId target, FrameId source, const std::optional<Time>& time, Outcome& part) {
    if (time) {
      LookupAt(target, source, time->nanoseconds, part);
    } else {
      LookupLatest(target, source, part);
    }
  };
  if (!query.travels) return find(query.target, query.source, query.source_time, outcome);
  find(query.target, query.fixed, query.target_time, outcome);
  if (outcome.fault != TransformFault::kNone) return;
  Outcome then;
  find(query.fixed, query.source, query.source_time, then);
  if (then.fault != TransformFault::kNone) {
    outcome = then;
    return;
  }
  outcome.pose = outcome.pose * then.pose;
}

TransformResult TreeCore::Result(const Outcome& outcome) const {
  if (outcome.fault != TransformFault::kNone) [[unlikely]]
    return TransformResult::Failed(Describe(outcome));
  // Copied number by number, like Pose.
  TransformResult result;
  StampedTransform& found = result.found_;
  found.T_target_source.rotation.w() = outcome.pose.w;
  found.T_target_source.rotation.x() = outcome.pose.x;
  found.T_target_source.rotation.y() = outcome.pose.y;
  found.T_target_source.rotation.z() = outcome.pose.z;
  found.T_target_source.translation.x() = outcome.pose.px;
  found.T_target_source.translation.y() = outcome.pose.py;
  found.T_target_source.translation.z() = outcome.pose.pz;
  found.stamp.nanoseconds = outcome.stamp;
  return result;
}

}  // namespace hgros::tf
