#include "tf/tree/memo.hpp"

#include <memory>

#include "hgros/base/thread_local.hpp"

namespace hgros::tf {
namespace {

constexpr std::size_t kPlacesBits = 6;  // 64 pairs, 24 KiB for each thread that looks up.

using Places = std::array<Memo, std::size_t{1} << kPlacesBits>;

// The pointer is read without a call; the owner only frees the memory.
constinit HGROS_THREAD_LOCAL Places* own_places = nullptr;

struct Owner {
  std::unique_ptr<Places> places = std::make_unique<Places>();
  Owner() { own_places = places.get(); }
  Owner(const Owner&) = delete;
  Owner& operator=(const Owner&) = delete;
  ~Owner() { own_places = nullptr; }
};

}  // namespace

Memo& Memo::PlaceFor(std::uint64_t tree, FrameId target, FrameId source) {
  if (own_places == nullptr) {
    HGROS_THREAD_LOCAL Owner owner;
    // A thread that looks up while it ends no longer has its own cache.
    if (own_places == nullptr) owner.places = std::make_unique<Places>(), own_places = owner.places.get();
  }
  const std::uint64_t pair = (std::uint64_t{target.value} << 32 | source.value) + tree;
  return (*own_places)[pair * 0x9E3779B97F4A7C15U >> (64 - kPlacesBits)];
}

}  // namespace hgros::tf
