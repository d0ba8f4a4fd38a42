#include "tf/tree/edge_writing.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace hgros::tf {
namespace {

constexpr unsigned kMovingChunkShift = 5;  // 2 KiB
constexpr unsigned kStaticChunkShift = 1;

bool Same(const Pose& a, const Pose& b) {
  return a.w == b.w && a.x == b.x && a.y == b.y && a.z == b.z && a.px == b.px && a.py == b.py && a.pz == b.pz;
}

// From now on the edge has only `values`.
void Exchange(Frame& edge, const std::vector<StampedPose>& values) {
  const SampleRing& read = *edge.ring.load(std::memory_order_relaxed);
  std::unique_ptr<SampleRing>& other = edge.rings[edge.rings[0].get() == &read ? 1 : 0];
  if (!other) other = std::make_unique<SampleRing>(kMovingChunkShift);
  other->Rewrite(values, read.End(), edge.limits);
  edge.ring.store(other.get(), std::memory_order_release);
}

void CountSet(Frame& edge) {
  edge.sets.store(edge.sets.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

// A transform that is not the newest: the edge's transforms are copied together with it into the other ring, and then
// readers use that ring. So no reader ever sees a ring that is being sorted.
bool Insert(Frame& edge, const StampedPose& value) {
  const SampleRing::Window window = edge.ring.load(std::memory_order_relaxed)->Look(edge.limits.count);
  const std::int64_t oldest = edge.limits.OldestFor(edge.newest);
  if (value.stamp < oldest) return false;
  std::vector<StampedPose> values;
  values.reserve(static_cast<std::size_t>(window.end - window.begin) + 1);
  for (std::uint64_t i = window.begin; i < window.end; ++i) {
    if (window[i].Stamp() >= oldest) values.push_back({window[i].Stamp(), window[i].Read()});
  }
  const auto place = std::lower_bound(values.begin(), values.end(), value.stamp,
                                      [](const StampedPose& a, std::int64_t stamp) { return a.stamp < stamp; });
  if (place != values.end() && place->stamp == value.stamp) {
    if (Same(place->pose, value.pose)) return true;
    *place = value;
  } else if (values.size() < edge.limits.count) {
    values.insert(place, value);
  } else {
    if (place == values.begin()) return false;
    std::move(values.begin() + 1, place, values.begin());
    *(place - 1) = value;
  }

  Exchange(edge, values);
  return true;
}

}  // namespace

void BeginEdge(Frame& edge, bool is_static, const RingLimits& limits, const StampedPose& first) {
  edge.is_static = is_static;
  edge.limits = is_static ? RingLimits{std::numeric_limits<std::int64_t>::max(), 1} : limits;
  edge.rings[0] = std::make_unique<SampleRing>(is_static ? kStaticChunkShift : kMovingChunkShift);
  edge.rings[0]->Append(first, edge.limits);
  edge.ring.store(edge.rings[0].get(), std::memory_order_release);
  edge.newest = first.stamp;
  edge.sets.store(1, std::memory_order_relaxed);
}

bool Write(Frame& edge, const StampedPose& value) {
  if (edge.is_static || value.stamp > edge.newest) {
    edge.ring.load(std::memory_order_relaxed)->Append(value, edge.limits);
    edge.newest = value.stamp;
  } else if (!Insert(edge, value)) {
    return false;
  }
  CountSet(edge);
  return true;
}

void Rewrite(Frame& edge, const StampedPose& value) {
  Exchange(edge, {value});
  edge.newest = value.stamp;
  CountSet(edge);
}

}  // namespace hgros::tf
