#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/bridge/known_channel.hpp"
#include "robot/overview.hpp"

namespace hgros::cli {

/// The hypergraph at one moment: processes with their nodes, and channels that join them. Names are as the robot gives
/// them, so not visible text yet.
struct Hypergraph {
  struct Node {
    std::string name;
    std::string channel;
    std::uint64_t dropped = 0;
    bool lossless = false;
  };
  /// A session. Two sessions of one process are two of these.
  struct Process {
    SessionId session;
    std::string name;  ///< "talker:4711"
    std::string host;
    std::vector<Node> nodes;
    std::size_t rank =
        0;  ///< 0: only publishes; the others come after those that they hear, as far as there is no cycle.
    std::string program = {};  ///< "talker"
    std::int64_t pid = 0;
  };
  struct Publisher {
    std::size_t process;
    double rate_hz = 0;
  };
  struct Subscriber {
    std::size_t process;
    std::optional<std::size_t> node;      ///< In the process; empty: its nodes are not known.
    std::vector<std::string> transports;  ///< From the publishers to this process, sorted; "process" inside one.
  };
  /// A hyperedge.
  struct Channel {
    std::string name;
    std::string type;
    double rate_hz = 0;
    std::uint64_t latched = 0;
    std::vector<Publisher> publishers;
    std::vector<Subscriber> subscribers;
  };

  std::vector<Process> processes;  ///< By host, then rank, then name.
  std::vector<Channel> channels;   ///< By the rank of the first publisher, then name.

  [[nodiscard]] static Hypergraph Of(const std::vector<KnownChannel>& channels, const AllCounters& counters);
  /// The part within `depth` channels of the process, session, node or channel with that name. Empty: there is none.
  [[nodiscard]] std::optional<Hypergraph> Around(std::string_view name, std::size_t depth) const;
  /// All names that Around() knows.
  [[nodiscard]] std::vector<std::string> Names() const;
  [[nodiscard]] const Node* NodeOf(const Subscriber& subscriber) const;
  /// Sets the ranks and the order, once processes and channels are there.
  void Arrange();

 private:
  void Rank();
  void Sort();
};

}  // namespace hgros::cli
