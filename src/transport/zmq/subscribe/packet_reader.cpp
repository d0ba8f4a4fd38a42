#include "transport/zmq/subscribe/packet_reader.hpp"

#include <algorithm>
#include <utility>

#include "transport/zmq/control.hpp"

namespace hgros::zmq {

PacketReader::Result PacketReader::Read(const Message& topic_frame, std::vector<Message>& frames) {
  const auto topic = ParseDataTopic(topic_frame.bytes());
  if (!topic || (topic->session.value != 0 && topic->session != shared_.self.info.id)) {
    const auto fault = frames.size() < 2 ? PacketFault::kTruncated : PacketFault::kTopic;
    shared_.CountFault(fault, connection_.endpoint(), "its first frame is not a topic of this session");
    return publisher_.alive ? Result::kGap : Result::kDone;
  }
  InLink* found = channels_.Find(std::string(topic->channel));
  if (found == nullptr) return Result::kDone;  // Just unsubscribed.
  InLink& link = *found;
  InboundPacket packet;
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(frames.size(), 2); ++i) bytes += frames[i].bytes().size();
  if (topic->session.value != 0) {
    if (link.id == 0 || !publisher_.known()) return Result::kDone;
    const std::uint64_t next = link.credit->received() + 1;
    if (topic->number != next)
      return link.active && link.certain && topic->number > next ? Result::kGap : Result::kDone;
    if (!link.credit->HasRoom()) {
      ReportDrop(link, PacketFault::kOverrun, "the publisher sent more than it had credit for", {});
      return Result::kTooMuch;
    }
    if (link.IsCrowded()) {
      link.credit->SkipMessage(bytes);
      ReportDrop(link, PacketFault::kOverrun, "the publisher's earlier links have left too much in flight", {});
      return Result::kDone;
    }
    packet.credit = link.credit->AdmitMessage(bytes);
    link.credit->OnReceived();
    packet.from = publisher_.id();
    packet.trusted = connection_.trusted();
    packet.fingerprint = link.fingerprint;
    packet.schema = link.schema;
  } else if (!link.plain) {
    return Result::kDone;  // Subscribed to before the publisher turned out to be a session.
  } else if (!link.plain_credit->HasRoomNow()) {
    ReportDrop(link, PacketFault::kOverrun, "a plain publisher sends faster than its messages are consumed", {});
    return Result::kDone;
  } else {
    packet.credit = link.plain_credit->AdmitMessage(bytes);
  }
  if (frames.size() != 2) {
    const auto fault = frames.size() < 2 ? PacketFault::kTruncated : PacketFault::kLength;
    ReportDrop(link, fault, "a packet has three frames", std::move(packet.credit));
    return Result::kDone;
  }
  packet.head = std::move(frames[0]);
  packet.data = std::move(frames[1]);
  inbox_.AddPacket(link.core, std::move(packet));
  return Result::kDone;
}

void PacketReader::ReportDrop(const InLink& link, PacketFault fault, std::string_view what,
                              std::shared_ptr<const void> credit) {
  inbox_.AddAction([this, core = link.core, fault, text = std::string(what), held = std::move(credit)] {
    ReportFault(*core, shared_, connection_.endpoint(), fault, "channel " + core->name + ": " + text);
  });
}

}  // namespace hgros::zmq
