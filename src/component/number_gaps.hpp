#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace hgros {

// Which numbers below the largest one have not come. Several threads that pass messages on may do so out of order, and
// some numbers never come. Knows of the newest 64 gaps.
class NumberGaps {
 public:
  // This number has come. `before`: the largest of those that came earlier; 0: not known.
  void Note(std::uint64_t before, std::uint64_t number);
  [[nodiscard]] bool Has(std::uint64_t number) const noexcept;
  [[nodiscard]] bool empty() const noexcept { return gaps_.empty(); }
  void Clear() noexcept { gaps_.clear(); }

 private:
  struct Gap {
    std::uint64_t first;
    std::uint64_t last;
  };
  static constexpr std::size_t kMost = 64;

  void Fill(std::uint64_t number);

  std::vector<Gap> gaps_;  // Ascending.
};

}  // namespace hgros
