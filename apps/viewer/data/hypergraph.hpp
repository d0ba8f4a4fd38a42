#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hgros/session/known_channel.hpp"
#include "viewer/data/session_counts.hpp"

namespace hgros::viewer {

/// Processes and the channels between them, as a picture to be laid out: sessions on one side, channels on the other,
/// and lines between.
struct Hypergraph {
  struct Process {
    SessionId session;
    std::string name;
    std::string host;
    std::int64_t pid = 0;
    bool own = false;  ///< The one that looks.
    std::string node;  ///< One node of the process, "#0" if it has no name of its own; empty: the process.
  };
  struct Channel {
    std::string name;
    std::string type;
    bool types_differ = false;         ///< Its users do not agree on that.
    std::optional<double> per_second;  ///< Published; if not all publishers tell, at least.
  };
  /// What the process, or the node, counts of the channel.
  struct Counts {
    std::uint64_t messages = 0;  ///< Published, or received.
    std::optional<double> per_second;
    std::uint64_t lost = 0;        ///< On the way from other processes.
    std::uint64_t unreadable = 0;  ///< Of those that came.
    std::uint64_t dropped = 0;     ///< By full queues: of its nodes, or, of a publisher, on the way to subscribers.
    std::uint64_t refused = 0;     ///< Not published.
    std::uint64_t failed = 0;      ///< Callbacks.
    std::int64_t run_p99_ns = 0;

    [[nodiscard]] bool has_faults() const noexcept { return lost + unreadable + dropped + refused + failed > 0; }
  };
  struct Line {
    std::size_t process = 0;  ///< Index into processes.
    std::size_t channel = 0;  ///< Index into channels.
    bool publishes = false;   ///< Else it subscribes.
    bool lossless = false;
    std::optional<Counts> counts{};  ///< Nothing: it has not told.
  };
  std::vector<Process> processes;  ///< By name, then by session.
  std::vector<Channel> channels;   ///< By name.
  std::vector<Line> lines;         ///< By channel; those who publish first.
};

struct HypergraphDetail {
  bool inner = false;  ///< With the library's own channels ("hgros/...") and who uses nothing else.
  bool nodes = false;  ///< Who subscribes stands there as the nodes that it tells of.
};

/// Puts together what a session knows; `own` is its id.
[[nodiscard]] Hypergraph MakeHypergraph(const std::vector<KnownChannel>& channels, SessionId own,
                                        const SessionCounts& counts, HypergraphDetail detail);

}  // namespace hgros::viewer
