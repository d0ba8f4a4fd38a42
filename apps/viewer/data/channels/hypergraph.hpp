#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hgros/bridge/known_channel.hpp"
#include "viewer/data/channels/session_counts.hpp"

namespace hgros::viewer {

/// Processes, channels, and the lines between them, before they have places in a picture.
struct Hypergraph {
  struct Process {
    SessionId session;
    std::string name;
    std::string host;
    std::int64_t pid = 0;
    bool own = false;  ///< The viewer's own process.
    std::string node;  ///< One node of the process, "#0" if it has no name of its own; empty: the process.
  };
  struct Channel {
    std::string name;
    std::string type;
    bool types_differ = false;         ///< Its users do not agree on the type.
    std::optional<double> per_second;  ///< Published rate; a lower bound if not all publishers report it.
  };
  /// The counts of the process, or of the node, for the channel.
  struct Counts {
    std::uint64_t messages = 0;  ///< Published, or received.
    std::optional<double> per_second;
    std::uint64_t lost = 0;        ///< On the way from other processes.
    std::uint64_t unreadable = 0;  ///< Received, but not readable.
    std::uint64_t dropped = 0;     ///< By full queues of its nodes; for a publisher, by full queues of its subscribers.
    std::uint64_t refused = 0;     ///< Not published.
    std::uint64_t failed = 0;      ///< Callbacks.
    std::int64_t run_p99_ns = 0;

    [[nodiscard]] bool has_faults() const noexcept { return lost + unreadable + dropped + refused + failed > 0; }
  };
  struct Line {
    std::size_t process = 0;  ///< Index into processes.
    std::size_t channel = 0;  ///< Index into channels.
    bool publishes = false;   ///< Otherwise it subscribes.
    bool lossless = false;
    std::optional<Counts> counts{};  ///< None: the session has not reported yet.
  };
  std::vector<Process> processes;  ///< By name, then by session.
  std::vector<Channel> channels;   ///< By name.
  std::vector<Line> lines;         ///< Sorted by channel; publishers come first.
};

struct HypergraphDetail {
  bool inner = false;  ///< Includes the library's own channels ("hgros/...") and processes that use only these.
  bool nodes = false;  ///< Shows each reported node of a subscriber instead of its process.
};

/// Builds the graph from what a session knows. `own` is the id of that session.
[[nodiscard]] Hypergraph MakeHypergraph(const std::vector<KnownChannel>& channels, SessionId own,
                                        const SessionCounts& counts, HypergraphDetail detail);

}  // namespace hgros::viewer
