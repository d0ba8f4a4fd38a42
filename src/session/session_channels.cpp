// What a session knows of channels, its own and others'.
#include <utility>

#include "session/channel_directory.hpp"
#include "session/session_core.hpp"

namespace hgros {
namespace {

// Bursts of changes, as when a program starts, are told as one.
constexpr auto kTimeToGather = std::chrono::milliseconds(20);

void SetType(ChannelUse& use, const TypeInfo& type) {
  if (IsAnyType(type)) return;
  use.type_name = type.name;
  use.encoding = type.encoding;
  use.fingerprint = type.fingerprint;
}

}  // namespace

SessionChannels Session::Core::OwnChannels() const {
  SessionChannels own;
  const Announcement self = AnnouncementOfThisProcess(id_, 0);
  own.session.id = id_;
  own.session.process = name_;
  own.session.host = self.host;
  own.session.pid = self.pid;
  const auto add = [&own](const std::string& channel) -> ChannelUse& {
    return own.channels.emplace_back(ChannelUse{.channel = channel});
  };
  for (const auto& [name, outlet] : outlets_) {
    ChannelUse& use = add(name);
    use.publishes = true;
    SetType(use, outlet->type());
  }
  const auto add_outlet = [&](const ChannelOutlet& outlet) {
    ChannelUse& use = add(outlet.channel());
    use.publishes = true;
    SetType(use, outlet.type());
  };
  for (const auto& outlet : service_outlets_) add_outlet(*outlet);
  if (snapshots_) add_outlet(*snapshots_->outlet());
  for (const auto& [name, inflow] : inflows_) {
    if (inflow.wanted.empty()) continue;
    ChannelUse& use = add(name);
    use.subscribes = true;
    use.lossless = Combine(inflow.wanted).lossless;
    SetType(use, inflow.inlet->channel_type());
  }
  return own;
}

std::vector<KnownChannel> Session::Core::Channels() {
  ChannelDirectory directory;
  const std::scoped_lock lock(mutex_);
  if (domain_ && !closing_) Reach();
  directory.Add({OwnChannels()});
  if (carriers_) {
    directory.Add(carriers_->AnnouncedChannels());
    if (const ZmqTransport* const zmq = carriers_->zmq()) directory.Add(zmq->KnownChannels());
  }
  return directory.Channels();
}

// On any thread, and perhaps often: costs next to nothing while nobody listens.
void Session::Core::OnChannels() noexcept {
  if (graph_->NodeCount(kChannelEventsChannel) == 0 || telling_channels_.exchange(true)) return;
  errands_->PostIn(kTimeToGather, [this] {
    telling_channels_ = false;
    (void)channel_events_(std::make_unique<ChannelsChanged>(ChannelsChanged{++channel_changes_}));
  });
}

// A channel that has its type already tells of that without asking anybody.
std::shared_ptr<const MessageSchema> Session::Core::AwaitSchema(std::string_view channel,
                                                                std::chrono::nanoseconds timeout) {
  Channel& opened = Open(channel, AnyType(), CallSite::Current());
  const TypeInfo& type = DataGraph::TypeOfChannel(opened);
  if (type.encoding != Encoding::kNone) return std::make_shared<const MessageSchema>(SchemaOf(type));
  NodeOptions options;
  options.queue = Queue::Latest();
  options.executor = Executor::Inline();
  const Subscription asking = SubscribeAny(
      opened, AnyType(), Invoke::kConcurrent, [](const AnyMessage&, const MessageInfo&) {}, options);
  std::shared_ptr<const MessageSchema> schema;
  (void)WaitUntil(timeout, [&] {
    const std::scoped_lock lock(mutex_);
    const auto inflow = inflows_.find(channel);
    schema = inflow == inflows_.end() ? nullptr : inflow->second.inlet->Schema();
    return schema != nullptr;
  });
  return schema;
}

}  // namespace hgros
