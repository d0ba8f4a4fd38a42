#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <hgros/Snapshot.pb.h>

namespace hgros::viewer {

/// The counts that sessions report and, from the second report on, how fast they grow. A session's report is bounded
/// but not checked. Thread safety: none.
class SessionCounts {
 public:
  /// The messages of one node or one channel, in one direction.
  struct Flow {
    std::uint64_t messages = 0;
    std::optional<double> per_second;  ///< Unknown until the session has reported twice.
  };
  struct Node {
    std::string name;
    Flow received;
    std::uint64_t dropped = 0;  ///< By its full queue.
    std::uint64_t failed = 0;   ///< Callbacks that ended with an exception.
    std::uint64_t queued = 0;   ///< Now.
    std::int64_t run_p50_ns = 0;
    std::int64_t run_p99_ns = 0;
  };
  struct Use {
    Flow published;
    std::uint64_t refused =
        0;  ///< Not published, for example because a lossless queue was full. Not part of `messages`.
    std::uint64_t send_dropped = 0;  ///< Dropped while sending, by full queues of subscribers.
    Flow received;                   ///< From other sessions.
    std::uint64_t lost = 0;          ///< Gaps in their sequence numbers.
    std::uint64_t faults = 0;        ///< Packets that could not be read.
    std::vector<Node> nodes;         ///< By name.
  };
  static constexpr std::size_t kMaxNodes = 1024;  ///< For one session.
  static constexpr std::size_t kMaxChannels = 4096;

  void Add(std::uint64_t session, const Snapshot& snapshot);
  /// Forgets all others.
  void Keep(const std::set<std::uint64_t>& sessions);

  /// Null if the session has not reported it. Valid until the next Add().
  [[nodiscard]] const Use* Find(std::uint64_t session, const std::string& channel) const;

 private:
  struct Told {
    std::int64_t steady_ns = 0;
    std::map<std::string, Use> channels;
  };
  std::map<std::uint64_t, Told> sessions_;
};

}  // namespace hgros::viewer
