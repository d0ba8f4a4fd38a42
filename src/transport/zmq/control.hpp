#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hgros/base/bytes.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/control.pb.h"

namespace hgros::zmq {

/// First byte of a control topic, and of every control message that goes upstream. ZeroMQ takes 0 and 1 there for
/// subscriptions; everything else passes as a message.
inline constexpr char kControlByte = '\x02';
/// Larger control messages are refused. The largest part of one is a descriptor set.
inline constexpr std::size_t kMaxControlBytes = 4u << 20;
/// The limit upstream, where the largest message is a Subscribe with a long type name. ZeroMQ closes the connection
/// of a larger one.
inline constexpr std::size_t kMaxUpstreamBytes = 64u << 10;
/// The channel of the publisher that gets the orders of its subscribers.
inline constexpr std::string_view kOrdersChannel = "hgros/control";
inline constexpr const char* kOrderRepliesChannel = "hgros/control/replies";
inline constexpr std::uint32_t kOrdersSinceMinor = 3;
/// Keeps an order below kMaxUpstreamBytes.
inline constexpr std::size_t kMaxOrderBytes = kMaxUpstreamBytes - 64;
[[nodiscard]] std::string ControlTopic(SessionId session);
[[nodiscard]] std::optional<SessionId> ParseControlTopic(std::string_view topic) noexcept;

/// A data packet's first frame. On a link it has 8 bytes more than the topic that the peer subscribed to: the message's
/// number on the link, u64 little-endian.
struct DataTopic {
  std::string_view channel;
  SessionId session;         ///< None for a plain topic.
  std::uint64_t number = 0;  ///< On the link; 0 for a plain topic.
};
[[nodiscard]] std::optional<DataTopic> ParseDataTopic(Bytes frame) noexcept;
/// Overwrites the last 8 bytes of `topic`.
void WriteLinkNumber(std::string& topic, std::uint64_t number) noexcept;

[[nodiscard]] std::optional<wire::Control> ParseControl(Bytes bytes);
[[nodiscard]] wire::Control ControlFrom(SessionId session);
/// An upstream message: kControlByte and the control message.
[[nodiscard]] std::string UpstreamFrame(const wire::Control& control);

}  // namespace hgros::zmq
