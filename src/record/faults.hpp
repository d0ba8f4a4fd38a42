#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/record/mcap_reader.hpp"

namespace hgros::mcap {

/// The damaged places of one file. The first 1,000 are remembered, and counted once, however often they are read.
class Faults {
 public:
  /// `what` names no place.
  void Add(std::uint64_t offset, std::string_view part, std::string_view what, std::uint64_t messages = 0) {
    if (places_.contains(offset)) return;
    ++count_;
    if (faults_.size() == kMaxFaults) return;
    places_.insert(offset);
    faults_.push_back({offset, fmt::format("The {} at byte {} cannot be read: {}.", part, offset, what), messages});
  }
  /// More messages that were lost at the place of the last fault.
  void AddLost(std::uint64_t offset, std::uint64_t messages) {
    if (!faults_.empty() && faults_.back().offset == offset) faults_.back().messages += messages;
  }
  [[nodiscard]] const std::vector<Fault>& list() const noexcept { return faults_; }
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }

 private:
  static constexpr std::size_t kMaxFaults = 1000;
  std::vector<Fault> faults_;
  std::set<std::uint64_t> places_;
  std::uint64_t count_ = 0;
};

}  // namespace hgros::mcap
