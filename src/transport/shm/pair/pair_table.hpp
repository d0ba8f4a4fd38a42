#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "transport/shm/pair/pair.hpp"

namespace hgros::shm {

/// The pairs of one transport, by the number under which the peer rings our bell.
///
/// Thread safety: all functions; the mutex is a leaf. Invariants: a number belongs to one pair, from Add() to Remove().
class PairTable {
 public:
  /// Gives the pair its number. False if there are kMaxPeers already.
  [[nodiscard]] bool Add(const std::shared_ptr<Pair>& pair) {
    const std::scoped_lock lock(mutex_);
    std::uint32_t number = 0;
    while (pairs_.contains(number)) ++number;
    if (number >= kMaxPeers) return false;
    pair->number = number;
    pairs_.emplace(number, pair);
    return true;
  }
  /// False if it is not there.
  bool Remove(const std::shared_ptr<Pair>& pair) {
    const std::scoped_lock lock(mutex_);
    const auto known = pairs_.find(pair->number);
    if (known == pairs_.end() || known->second != pair) return false;
    pairs_.erase(known);
    return true;
  }
  [[nodiscard]] std::vector<std::shared_ptr<Pair>> RemoveAll() {
    const std::scoped_lock lock(mutex_);
    std::vector<std::shared_ptr<Pair>> list;
    for (auto& [number, pair] : pairs_) list.push_back(std::move(pair));
    pairs_.clear();
    return list;
  }
  [[nodiscard]] std::vector<std::shared_ptr<Pair>> List() const {
    const std::scoped_lock lock(mutex_);
    std::vector<std::shared_ptr<Pair>> list;
    list.reserve(pairs_.size());
    for (const auto& [number, pair] : pairs_) list.push_back(pair);
    return list;
  }
  /// Null if the number belongs to no pair.
  [[nodiscard]] std::shared_ptr<Pair> At(std::uint32_t number) const {
    const std::scoped_lock lock(mutex_);
    const auto found = pairs_.find(number);
    return found == pairs_.end() ? nullptr : found->second;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::uint32_t, std::shared_ptr<Pair>> pairs_;
};

}  // namespace hgros::shm
