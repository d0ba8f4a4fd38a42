#pragma once

#include <cstddef>

namespace hgros::viewer {

/// One of `count` parts of the settled layer, spread evenly: the elements at index, index + count, ... All parts, in
/// any order, make the whole picture. A single part looks like the whole, but thinner.
struct Slice {
  std::size_t index = 0;
  std::size_t count = 1;
};

}  // namespace hgros::viewer
