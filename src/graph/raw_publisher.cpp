#include "hgros/graph/raw_publisher.hpp"

#include "hgros/codec/run_time_type.hpp"

namespace hgros {
namespace {

MessageOffer OfferOfRaw(const RawMessage& message) {
  return {&message,
          [](void* context) -> AnyMessage {
            return std::make_shared<const RawMessage>(*static_cast<const RawMessage*>(context));
          },
          const_cast<RawMessage*>(&message), &AnyType};
}

}  // namespace

PublishStatus PublishRaw(Channel& channel, const std::shared_ptr<const MessageSchema>& schema, const Payload& data,
                         Reach reach) {
  const RawMessage message{schema, OwnedPayload(data)};
  return Publish(channel, OfferOfRaw(message), reach);
}

PublishStatus RawPublisher::operator()(const Payload& data) const {
  return channel_ ? PublishRaw(*channel_, schema_, data, reach_) : PublishStatus::kClosed;
}

PublishStatus RawPublisher::Wait(const Payload& data, std::chrono::steady_clock::time_point deadline,
                                 const std::stop_token& stop) const {
  if (!channel_) return PublishStatus::kClosed;
  const RawMessage message{schema_, OwnedPayload(data)};
  return PublishWait(*channel_, OfferOfRaw(message), reach_, deadline, stop);
}

}  // namespace hgros
