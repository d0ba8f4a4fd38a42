#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "tf/tree/pose.hpp"

namespace hgros::tf {

/// `b` - `a`, for stamps that may be any number.
inline std::int64_t Between(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(b) - static_cast<std::uint64_t>(a));
}

struct StampedPose {
  std::int64_t stamp = 0;  ///< ns
  Pose pose = IdentityPose();
};

/// One transform of an edge: a cache line of words that readers may read while they are written.
struct alignas(64) Sample {
  std::atomic<std::int64_t> stamp;
  std::atomic<double> w, x, y, z, px, py, pz;

  [[nodiscard]] std::int64_t Stamp() const { return stamp.load(std::memory_order_relaxed); }
  [[nodiscard]] Pose Read() const {
    constexpr auto kRelaxed = std::memory_order_relaxed;
    return {w.load(kRelaxed),  x.load(kRelaxed),  y.load(kRelaxed), z.load(kRelaxed),
            px.load(kRelaxed), py.load(kRelaxed), pz.load(kRelaxed)};
  }
  void ReadTo(Pose& pose) const { pose = Read(); }
  void Write(const StampedPose& value) {
    constexpr auto kRelaxed = std::memory_order_relaxed;
    stamp.store(value.stamp, kRelaxed);
    w.store(value.pose.w, kRelaxed);
    x.store(value.pose.x, kRelaxed);
    y.store(value.pose.y, kRelaxed);
    z.store(value.pose.z, kRelaxed);
    px.store(value.pose.px, kRelaxed);
    py.store(value.pose.py, kRelaxed);
    pz.store(value.pose.pz, kRelaxed);
  }
};

/// The limits of an edge's buffer.
struct RingLimits {
  std::int64_t duration = 0;  ///< ns before the newest stamp
  std::uint64_t count = 0;

  /// The oldest stamp within the limits, in addition to the newest.
  [[nodiscard]] std::int64_t OldestFor(std::int64_t newest) const {
    std::int64_t oldest = 0;
    return __builtin_sub_overflow(newest, duration, &oldest) ? INT64_MIN : oldest;
  }
};

/// The transforms of one edge, by growing stamps. Transforms are numbered from 0 without end. Number i is in chunk i
/// / chunk size, and a directory has the chunk's address. A chunk whose transforms are all beyond the limits is
/// reused as the next one. Otherwise a new chunk is made, and sometimes a larger directory.
///
/// Thread safety: one writer at a time, any number of readers, who take no lock and never wait.
/// Invariants: a reader takes intact(), size and places in a Window, reads transforms, and then asks StillThere for
/// the lowest number that it has read. Before the writer writes into a chunk again, it raises intact() beyond it,
/// followed by a fence. So a reader that has read a word of the new content sees the raised intact(). Memory is given
/// back only when the ring ends.
class SampleRing {
 public:
  /// A reader's view of the ring; it contains the numbers [begin, end).
  class Window {
   public:
    [[nodiscard]] const Sample& operator[](std::uint64_t number) const {
      const std::atomic<Sample*>& place = places_[(number >> shift_) & mask_];
      return place.load(std::memory_order_acquire)[number & ((std::uint64_t{1} << shift_) - 1)];
    }
    std::uint64_t begin = 0;
    std::uint64_t end = 0;

   private:
    friend class SampleRing;
    const std::atomic<Sample*>* places_ = nullptr;
    std::uint64_t mask_ = 0;
    unsigned shift_ = 0;
  };

  /// Chunks of 2^chunk_shift transforms.
  explicit SampleRing(unsigned chunk_shift);

  // Readers.

  /// Empty only while the ring is being rewritten: then another one is in use.
  [[nodiscard]] Window Look(std::uint64_t max_count) const {
    Window window;
    const std::uint64_t intact = intact_.load(std::memory_order_acquire);
    window.end = end_.load(std::memory_order_acquire);
    const Directory* directory = directory_.load(std::memory_order_acquire);
    window.begin = window.end > intact + max_count ? window.end - max_count : intact;
    window.places_ = directory->places.get();
    window.mask_ = directory->mask;
    window.shift_ = shift_;
    return window;
  }
  /// Whether nothing from `number` on was overwritten while the reader read it.
  [[nodiscard]] bool StillThere(std::uint64_t number) const {
    std::atomic_thread_fence(std::memory_order_acquire);
    return intact_.load(std::memory_order_relaxed) <= number;
  }
  /// One past the newest number, and the newest transform or one that has come since.
  [[nodiscard]] std::uint64_t End() const { return end_.load(std::memory_order_acquire); }
  [[nodiscard]] const Sample& Newest() const { return *newest_.load(std::memory_order_acquire); }
  /// Transforms per ns in the buffer; a hint for searching.
  [[nodiscard]] double Rate() const { return rate_.load(std::memory_order_relaxed); }

  // The writer.

  /// `value` is newer than all others.
  void Append(const StampedPose& value, const RingLimits& limits);
  /// Replaces the content of the ring by `values`, which are in order. Readers that still use this ring find it empty
  /// meanwhile.
  void Rewrite(const std::vector<StampedPose>& values, std::uint64_t first, const RingLimits& limits);

 private:
  struct Directory {
    explicit Directory(std::size_t size) : mask(size - 1), places(new std::atomic<Sample*>[size]) {}
    std::uint64_t mask;
    std::unique_ptr<std::atomic<Sample*>[]> places;
  };

  [[nodiscard]] Sample& At(std::uint64_t number) {
    return places_[(number >> shift_) & mask_].load(
        std::memory_order_relaxed)[number & ((std::uint64_t{1} << shift_) - 1)];
  }
  Sample& Put(std::uint64_t number, const StampedPose& value, const RingLimits& limits);
  void EnterChunk(std::uint64_t chunk, std::int64_t stamp, const RingLimits& limits);
  [[nodiscard]] bool MayGo(std::uint64_t chunk, std::uint64_t number, std::int64_t stamp, const RingLimits& limits);
  void Enlarge(std::uint64_t chunk);

  // Read by readers.
  alignas(64) std::atomic<std::uint64_t> intact_{0};  ///< The lowest number that was not overwritten.
  std::atomic<std::uint64_t> end_{0};
  std::atomic<Sample*> newest_{nullptr};  ///< Set before end_.
  std::atomic<const Directory*> directory_{nullptr};
  std::atomic<double> rate_{0};
  unsigned shift_;
  // The writer's own.
  alignas(64) std::atomic<Sample*>* places_ = nullptr;
  std::uint64_t mask_ = 0;
  std::uint64_t first_chunk_ = 0;  ///< The lowest that the directory has.
  std::uint64_t free_below_ = 0;   ///< Chunks below it hold no transforms within the limits.
  std::vector<std::unique_ptr<Directory>> directories_;
  std::vector<std::unique_ptr<Sample[]>> chunks_;
};

}  // namespace hgros::tf
