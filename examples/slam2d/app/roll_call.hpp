#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include <hgros/hgros.hpp>

#include "console.hpp"
#include "ending.hpp"
#include "messages.hpp"

namespace slam2d {

/// Tracks on channel `ready` which process runs which node and is ready, and whether it is still there. If one of them
/// disappears before the work is done, the program ends with a sentence.
///
/// Threading: thread-safe.
class RollCall {
 public:
  RollCall(hgros::Session& session, Ending& ending);

  /// Announces that these nodes run here and have all their inputs. `next_scan`: set by a mapper that takes over.
  void Answer(const std::set<std::string>& nodes, std::uint64_t next_scan = 0);

  /// Waits until all `nodes` have answered, in any process. Returns those that have not by `deadline` or when the
  /// program ends.
  [[nodiscard]] std::vector<std::string> WaitFor(const std::vector<std::string>& nodes,
                                                 std::chrono::steady_clock::time_point deadline);
  /// Waits for a mapper in another process that continues with scan `next_scan`. Returns its session, or an empty text
  /// if there is none.
  [[nodiscard]] std::string WaitForSuccessor(std::uint64_t next_scan, std::chrono::steady_clock::time_point deadline);

 private:
  struct Member {
    std::set<std::string> nodes;
    std::uint64_t next_scan = 0;
  };

  void TakeReady(const msg::Ready& message);
  void TakeEvent(const hgros::PeerEvent& event);

  Ending& ending_;
  const std::stop_token stop_;
  const std::string session_;
  hgros::Publisher<msg::Ready> ready_;

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::map<std::string, Member> members_;  // By session.

  hgros::Subscription ready_subscription_;
  hgros::Subscription event_subscription_;
};

}  // namespace slam2d
