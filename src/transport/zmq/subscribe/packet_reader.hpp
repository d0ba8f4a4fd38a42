#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "transport/zmq/shared_state.hpp"
#include "transport/zmq/socket.hpp"
#include "transport/zmq/subscribe/inbox.hpp"
#include "transport/zmq/subscribe/publisher_connection.hpp"
#include "transport/zmq/subscribe/remote_publisher.hpp"
#include "transport/zmq/subscribe/subscribed_channels.hpp"

namespace hgros::zmq {

/// Matches data packets with their links and counts them against credit. Good packets, and calls that report bad
/// ones, go to the inbox.
/// Thread safety: none; the leading thread calls it under the endpoint's mutex.
class PacketReader {
 public:
  enum class Result {
    kDone,
    kTooMuch,  ///< The publisher sent more than it had credit for: nothing more must be read from it.
    kGap,      ///< It, or a message before it, is lost. It comes again after the next handshake.
  };

  PacketReader(SharedState& shared, const PublisherConnection& connection, const RemotePublisher& publisher,
               SubscribedChannels& channels, Inbox& inbox)
      : shared_(shared), connection_(connection), publisher_(publisher), channels_(channels), inbox_(inbox) {}

  [[nodiscard]] Result Read(const Message& topic, std::vector<Message>& frames);

 private:
  /// Reports a dropped packet to the channel. `credit` is held until then.
  void ReportDrop(const InLink& link, PacketFault fault, std::string_view what, std::shared_ptr<const void> credit);

  SharedState& shared_;
  const PublisherConnection& connection_;
  const RemotePublisher& publisher_;
  SubscribedChannels& channels_;
  Inbox& inbox_;
};

}  // namespace hgros::zmq
