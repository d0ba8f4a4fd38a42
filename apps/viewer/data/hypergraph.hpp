#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hgros/session/known_channel.hpp"
#include "hgros/session/snapshot.hpp"

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
  };
  struct Channel {
    std::string name;
    std::string type;
    bool types_differ = false;  ///< Its users do not agree on that.
  };
  struct Line {
    std::size_t process = 0;  ///< Index into processes.
    std::size_t channel = 0;  ///< Index into channels.
    bool publishes = false;   ///< Else it subscribes.
    bool lossless = false;
    std::uint64_t dropped = 0;  ///< Of the own nodes: by full queues.
  };
  std::vector<Process> processes;  ///< By name, then by session.
  std::vector<Channel> channels;   ///< By name.
  std::vector<Line> lines;         ///< By channel; those who publish first.
};

enum class Inner { kLeftOut, kShown };

/// Puts together what a session knows. The library's own channels ("hgros/...") are left out unless `inner` says so,
/// and so are processes that are then without a line.
[[nodiscard]] Hypergraph MakeHypergraph(const std::vector<KnownChannel>& channels, const SessionSnapshot& own,
                                        Inner inner);

}  // namespace hgros::viewer
