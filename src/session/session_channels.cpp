// The part of SessionCore that lists channels, its own and those of other sessions.
#include <utility>

#include "hgros/bridge/channel_directory.hpp"
#include "session/session_core.hpp"

namespace hgros {
SessionChannels SessionCore::OwnChannels() const {
  SessionChannels own;
  const Announcement self = AnnouncementOfThisProcess(id_, 0);
  own.session.id = id_;
  own.session.process = name_;
  own.session.host = self.host;
  own.session.pid = self.pid;
  outbound_.AddTo(own.channels);
  if (reports_) reports_->AddTo(own.channels);
  inbound_->AddTo(own.channels);
  return own;
}

std::vector<KnownChannel> SessionCore::Channels() {
  ChannelDirectory directory;
  const std::scoped_lock lock(mutex_);
  if (domain_ && !closing_) EnsureTransports();
  directory.Add({OwnChannels()});
  if (bridge_) bridge_->ListChannels(directory);
  return directory.Channels();
}

void SessionCore::OnChannels() noexcept {
  events_->PublishChannels(*errands_);
  changes_.Notify();
}

// If the channel has its type already, no publisher is asked.
std::shared_ptr<const MessageSchema> SessionCore::AwaitSchema(std::string_view channel,
                                                              std::chrono::nanoseconds timeout) {
  RequireOtherThanRequests(channel, CallSite::Current());
  Channel& opened = graph_->Open(channel, AnyType(), CallSite::Current());
  const TypeInfo& type = DataGraph::TypeOfChannel(opened);
  if (type.encoding != Encoding::kNone) return std::make_shared<const MessageSchema>(SchemaOf(type));
  const Subscription asking =
      SubscribeAny(opened, AnyType(), Invoke::kConcurrent, [](const AnyMessage&, const MessageInfo&) {},
                   {{}, Queue::Latest(), Executor::Inline()});
  std::shared_ptr<const MessageSchema> schema;
  (void)WaitUntil(timeout, [&] {
    schema = inbound_->SchemaOf(channel);
    return schema != nullptr;
  });
  return schema;
}

}  // namespace hgros
