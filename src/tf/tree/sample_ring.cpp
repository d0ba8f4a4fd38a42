#include "tf/tree/sample_ring.hpp"

#include <algorithm>
#include <utility>

namespace hgros::tf {

SampleRing::SampleRing(unsigned chunk_shift) : shift_(chunk_shift) {
  Enlarge(0);
  chunks_.push_back(std::make_unique<Sample[]>(std::size_t{1} << shift_));
  for (std::uint64_t i = 0; i <= mask_; ++i) places_[i].store(chunks_.back().get(), std::memory_order_release);
}

void SampleRing::Append(const StampedPose& value, const RingLimits& limits) {
  const std::uint64_t number = end_.load(std::memory_order_relaxed);
  newest_.store(&Put(number, value, limits), std::memory_order_release);
  end_.store(number + 1, std::memory_order_release);
}

void SampleRing::Rewrite(const std::vector<StampedPose>& values, std::uint64_t first, const RingLimits& limits) {
  const std::uint64_t from = std::max(first, end_.load(std::memory_order_relaxed));
  const std::uint64_t chunk = (from + (std::uint64_t{1} << shift_) - 1) >> shift_;
  std::uint64_t number = chunk << shift_;
  free_below_ = chunk;
  intact_.store(number, std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_release);
  // Its present chunks become those before it.
  const std::uint64_t end = end_.load(std::memory_order_relaxed);
  std::vector<Sample*> chunks;
  for (std::uint64_t i = first_chunk_; i <= (end == 0 ? 0 : (end - 1) >> shift_); ++i) {
    chunks.push_back(places_[i & mask_].load(std::memory_order_relaxed));
  }
  first_chunk_ = chunk - chunks.size();
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    places_[(first_chunk_ + i) & mask_].store(chunks[i], std::memory_order_release);
  }
  Sample* newest = nullptr;
  for (const StampedPose& value : values) newest = &Put(number++, value, limits);
  newest_.store(newest, std::memory_order_release);
  end_.store(number, std::memory_order_release);
}

Sample& SampleRing::Put(std::uint64_t number, const StampedPose& value, const RingLimits& limits) {
  if ((number & ((std::uint64_t{1} << shift_) - 1)) == 0 && number != 0)
    EnterChunk(number >> shift_, value.stamp, limits);
  Sample& sample = At(number);
  sample.Write(value);
  return sample;
}

void SampleRing::EnterChunk(std::uint64_t chunk, std::int64_t stamp, const RingLimits& limits) {
  const std::uint64_t number = chunk << shift_;
  Sample* place = nullptr;
  if (first_chunk_ < chunk && MayGo(first_chunk_, number, stamp, limits)) {
    place = places_[first_chunk_ & mask_].load(std::memory_order_relaxed);
    ++first_chunk_;
    if (first_chunk_ > free_below_) {
      intact_.store(first_chunk_ << shift_, std::memory_order_relaxed);
      std::atomic_thread_fence(std::memory_order_release);
    }
  } else {
    chunks_.push_back(std::make_unique<Sample[]>(std::size_t{1} << shift_));
    place = chunks_.back().get();
  }
  if (chunk - first_chunk_ > mask_) Enlarge(chunk);
  places_[chunk & mask_].store(place, std::memory_order_release);
  if (first_chunk_ < chunk && first_chunk_ >= free_below_) {
    const std::uint64_t first = first_chunk_ << shift_;
    const std::int64_t time = Between(At(first).Stamp(), stamp);
    rate_.store(time > 0 ? static_cast<double>(number - first) / static_cast<double>(time) : 0,
                std::memory_order_relaxed);
  }
}

// `number` is about to be written. The newest transform that readers see is the one before it, and must stay until
// the new one is published.
bool SampleRing::MayGo(std::uint64_t chunk, std::uint64_t number, std::int64_t stamp, const RingLimits& limits) {
  if (chunk < free_below_) return true;
  const std::uint64_t next = (chunk + 1) << shift_;
  if (next >= number) return false;
  return next + limits.count <= number + 1 || At(next - 1).Stamp() < limits.OldestFor(stamp);
}

void SampleRing::Enlarge(std::uint64_t chunk) {
  const std::size_t size = directories_.empty() ? 4 : 2 * (static_cast<std::size_t>(mask_) + 1);
  auto larger = std::make_unique<Directory>(size);
  for (std::uint64_t i = 0; i < size; ++i) {
    // Unused places also hold a chunk, so that a late reader never reads missing memory.
    larger->places[i].store(places_ == nullptr ? nullptr : places_[i & mask_].load(std::memory_order_relaxed),
                            std::memory_order_relaxed);
  }
  for (std::uint64_t i = first_chunk_; i < chunk; ++i) {
    larger->places[i & larger->mask].store(places_[i & mask_].load(std::memory_order_relaxed),
                                           std::memory_order_relaxed);
  }
  mask_ = larger->mask;
  places_ = larger->places.get();
  directory_.store(larger.get(), std::memory_order_release);
  directories_.push_back(std::move(larger));
}

}  // namespace hgros::tf
