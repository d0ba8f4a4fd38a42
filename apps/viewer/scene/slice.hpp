#pragma once

#include <cstddef>

namespace hgros::viewer {

/// One of `count` parts of everything that is settled, spread evenly over it: what of n things lies at index, index +
/// count, ... The whole picture is all the parts, in any order; one of them looks like the whole, but thinner.
struct Slice {
  std::size_t index = 0;
  std::size_t count = 1;
};

}  // namespace hgros::viewer
