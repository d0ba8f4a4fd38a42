#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "hgros/control.pb.h"
#include "transport/zmq/clock_question.hpp"
#include "transport/zmq/publish/out_link.hpp"

namespace hgros::zmq {

/// A session's wish for one channel, and the link that serves it, if there is one.
struct Wish {
  wire::Subscribe asked;
  int connection = -1;  ///< The descriptor that it came over.
  std::unique_ptr<OutLink> link;
  /// Like the bytes of topics (AcceptedConnections), each of which takes about 40 bytes of memory.
  [[nodiscard]] std::size_t size() const { return 8 + asked.ByteSizeLong() / 8; }
};

/// A session that subscribes at a publish endpoint.
/// Thread safety: none; the endpoint's mutex guards it.
struct SubscriberPeer {
  /// For the log.
  [[nodiscard]] std::string name() const { return facts.info.name(); }

  SessionFacts facts;
  std::string topic;            ///< Its control topic.
  std::uint64_t handshake = 0;  ///< Of the latest Welcome that it has answered, or that has paused its links.
  int connection = -1;          ///< The descriptor that its latest Hello came over.
  std::uint64_t proof = 0;      ///< Of all its Hellos; 0: of none.
  SteadyTime last_heard{};
  bool cut = false;       ///< Its connection has ended, and it gets some time to come back.
  bool replaced = false;  ///< Another session publishes where it did.
  ClockQuestion clock;
  /// At the end: asked over this connection after everything else; 0: not asked. It answers when it has read all that.
  std::int64_t last_question = 0;
  bool asked = false;                                   ///< Over this connection or an earlier one.
  bool received_all = false;                            ///< It has answered the last question.
  std::uint64_t waiting_bytes = 0;                      ///< The sum of all its links.
  std::unordered_map<std::string, Wish> wishes;         ///< By channel.
  std::size_t wish_bytes = 0;                           ///< Wish::size() of all.
  std::unordered_set<std::string> reported_mismatches;  ///< Channels.
};

}  // namespace hgros::zmq
