#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "robot/overview.hpp"
#include "terminal/records.hpp"

namespace hgros::cli {

enum class TopKind { kSessions, kNodes, kChannels };
inline constexpr TopKind kTopKinds[] = {TopKind::kSessions, TopKind::kNodes, TopKind::kChannels};

/// The columns of a list, the most important ones first.
[[nodiscard]] const std::vector<Column>& TopColumns(TopKind kind);
/// The column by which a list is sorted at first.
[[nodiscard]] std::size_t FirstSortOf(TopKind kind);

/// A session, a node or a channel, with what it does now.
struct TopRow {
  TopKind kind = TopKind::kSessions;
  std::string id;  ///< Stays the same as long as it is there; no other row has it.
  SessionId session{};
  std::string channel;         ///< The name; of a session: empty.
  std::string node;            ///< The name, if it is a node.
  std::size_t same_named = 0;  ///< Nodes of that name on that channel in that session that come before it.
  bool silent = false;         ///< Its session sends no counters now.
  std::vector<Cell> cells;     ///< One for each column.
};

/// What sessions, nodes and channels do now: the differences between the last two snapshots of each session.
///
/// Threading: one thread.
class Activity {
 public:
  /// `all`: also the channels of the library itself.
  Activity(OutputStyle style, bool all) : style_(style), all_(all) {}

  /// Takes the newest counters. Call it about once a second. A session without newer counters for four calls is silent.
  void Update(const AllCounters& counters, const std::vector<KnownChannel>& channels);
  /// By name.
  [[nodiscard]] const std::vector<TopRow>& Rows(TopKind kind) const { return rows_[static_cast<std::size_t>(kind)]; }

 private:
  struct Known {
    std::shared_ptr<const Snapshot> before;  // Null at first.
    std::shared_ptr<const Snapshot> now;
    int unchanged = 0;  // Calls without newer counters.
  };
  struct ChannelSum;
  struct SessionSum;

  void Take(const AllCounters& counters);
  void AddSession(const ChannelUser& user, std::map<std::string_view, ChannelSum>& sums, bool several_hosts);
  void AddNodes(const std::vector<Cell>& session, const Known& known, const Snapshot::Channel& channel,
                const Snapshot::Channel* before, SessionSum& sum);
  void AddChannel(const KnownChannel& channel, const ChannelSum& sum, const AllCounters& counters);

  [[nodiscard]] Cell Rate(std::optional<double> hertz) const;
  [[nodiscard]] Cell Percent(std::optional<double> percent) const;
  [[nodiscard]] Cell Time(std::int64_t ns) const;
  [[nodiscard]] Cell Drops(std::optional<double> per_second) const;

  const OutputStyle style_;
  const bool all_;
  std::map<SessionId, Known> known_;
  std::vector<TopRow> rows_[std::size(kTopKinds)];
};

}  // namespace hgros::cli
