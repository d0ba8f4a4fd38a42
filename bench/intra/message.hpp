#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace hgros::bench {

/// The message that is passed by pointer: a block of a given size.
struct Parcel {
  explicit Parcel(std::size_t size) : bytes(size) {}
  std::vector<std::byte> bytes;
};
using ParcelPtr = std::shared_ptr<const Parcel>;

}  // namespace hgros::bench
