#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/base/transport_keys.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

/// Which sessions a transport can reach.
enum class TransportReach { kHost, kNetwork };

/// A transport that a session can use.
struct TransportEntry {
  std::string key;   ///< In configurations and announcements: "shared_memory".
  std::string name;  ///< For logs and tables: "shared memory".
  int cost = 0;      ///< The transport with the lowest cost that reaches a session is used.
  TransportReach reach = TransportReach::kNetwork;
  /// Whether that session's messages on the channel are to be received over this transport.
  using Takes = std::function<bool(SessionId publisher, std::string_view channel)>;
  /// Makes the transport. Throws Error. Empty: this session does not have it.
  std::function<std::unique_ptr<Transport>(Takes takes, TransportListener& listener, Log& log)> make;
  bool opens_at_start = true;  ///< Otherwise when it is first asked for.
};

/// A transport's position in its TransportList. The cheapest transport has 0.
using TransportIndex = std::size_t;

/// Some of the transports of one list.
class TransportSet {
 public:
  static constexpr std::size_t kMost = 32;

  TransportSet() = default;
  TransportSet(std::initializer_list<TransportIndex> transports) {
    for (const TransportIndex one : transports) Add(one);
  }
  void Add(TransportIndex transport) noexcept { bits_ |= std::uint32_t{1} << transport; }
  [[nodiscard]] bool Has(TransportIndex transport) const noexcept { return (bits_ >> transport & 1U) != 0; }
  [[nodiscard]] bool empty() const noexcept { return bits_ == 0; }
  [[nodiscard]] TransportSet In(TransportSet other) const noexcept { return TransportSet(bits_ & other.bits_); }
  [[nodiscard]] TransportSet Or(TransportSet other) const noexcept { return TransportSet(bits_ | other.bits_); }
  [[nodiscard]] TransportSet Without(TransportSet other) const noexcept { return TransportSet(bits_ & ~other.bits_); }
  [[nodiscard]] TransportSet CheaperThan(TransportIndex transport) const noexcept {
    return TransportSet(bits_ & ((std::uint32_t{1} << transport) - 1));
  }
  [[nodiscard]] std::optional<TransportIndex> cheapest() const noexcept {
    return empty() ? std::nullopt : std::optional<TransportIndex>(std::countr_zero(bits_));
  }
  bool operator==(const TransportSet&) const = default;
  /// An order for maps.
  bool operator<(const TransportSet& other) const noexcept { return bits_ < other.bits_; }

 private:
  explicit TransportSet(std::uint32_t bits) noexcept : bits_(bits) {}
  std::uint32_t bits_ = 0;
};

/// By channel, the transports that it may use; a channel that is not named may use all.
using TransportRules = std::map<std::string, TransportSet, std::less<>>;

/// All transports that a session knows, the cheapest first. Immutable.
class TransportList {
 public:
  /// Throws Error if two have one key, or if there are more than TransportSet::kMost.
  explicit TransportList(std::vector<TransportEntry> entries);

  [[nodiscard]] std::size_t size() const noexcept { return entries_.size(); }
  [[nodiscard]] const TransportEntry& operator[](TransportIndex transport) const { return entries_[transport]; }
  [[nodiscard]] const std::string& name(TransportIndex transport) const { return entries_[transport].name; }
  [[nodiscard]] std::optional<TransportIndex> Find(std::string_view key) const;
  [[nodiscard]] TransportSet all() const noexcept { return all_; }
  /// Those that reach sessions of this host only.
  [[nodiscard]] TransportSet on_host() const noexcept { return on_host_; }
  /// Keys that are not in the list are left out.
  [[nodiscard]] TransportSet SetOf(const TransportKeys& keys) const;
  /// "shared memory and ZeroMQ".
  [[nodiscard]] std::string NamesOf(TransportSet transports) const;

 private:
  std::vector<TransportEntry> entries_;
  TransportSet all_;
  TransportSet on_host_;
};

}  // namespace hgros
