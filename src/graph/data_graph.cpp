#include "hgros/graph/data_graph.hpp"

#include <algorithm>
#include <utility>

#include "graph/graph_core.hpp"
#include "graph/nodes/callback_scope.hpp"

namespace hgros {

DataGraph::DataGraph(GraphOptions options, std::shared_ptr<Log> log)
    : core_(std::make_shared<GraphCore>(std::move(options), std::move(log))) {}

DataGraph::~DataGraph() {
  if (core_->in_forked_child() || core_->EndsInside()) {
    LeaveToParent(std::move(core_));
  } else {
    core_->Shutdown();
  }
}

Channel& DataGraph::Open(std::string_view channel, const TypeInfo& type, const CallSite& where) {
  return core_->Open(channel, type, where);
}

std::shared_ptr<Channel> DataGraph::Share(Channel& channel) const { return {core_, &channel}; }

Subscription DataGraph::Subscribe(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                                  NodeOptions options) {
  return Subscription(core_, channel, core_->Subscribe(channel, type, invoke, std::move(callback), std::move(options)));
}

void DataGraph::Latch(Channel& channel, std::size_t count) { channel.Latch(count); }

void DataGraph::ReplaceLatched(std::string_view channel, std::vector<AnyMessage> messages, const TypeInfo& type,
                               SessionId other) {
  if (Channel* const found = core_->Find(channel)) found->ReplaceLatched(std::move(messages), type, other.value);
}

bool DataGraph::ForgetRemoteLatched(Channel& channel) { return channel.ForgetRemoteLatched(); }

void DataGraph::SetOutlet(Channel& channel, std::shared_ptr<Outlet> outlet) { channel.SetOutlet(std::move(outlet)); }

bool DataGraph::HasOutlet(const Channel& channel) noexcept { return channel.HasOutlet(); }

bool DataGraph::Inject(Channel& channel, const AnyMessage& message, const TypeInfo& type, const MessageInfo& info,
                       std::shared_ptr<const void> credit, std::size_t latched, UserCode user_code) noexcept {
  return channel.Inject(message, type, info, std::move(credit), latched, user_code);
}

const TypeInfo& DataGraph::InboundType(const Channel& channel) noexcept { return channel.InboundType(); }

ThreadUse DataGraph::UseOfThread(const Channel& channel) noexcept { return channel.UseOfThread(); }

bool DataGraph::InCallback() noexcept { return CallbackScope::InAny(); }

void DataGraph::NotifyRoom(Channel& channel) noexcept { channel.NotifyRoom(); }

const TypeInfo& DataGraph::TypeOfChannel(const Channel& channel) noexcept { return channel.type(); }

const std::string& DataGraph::NameOf(const Channel& channel) noexcept { return channel.name(); }

std::size_t DataGraph::NodeCount(std::string_view channel) const noexcept {
  const Channel* found = core_->Find(channel);
  return found == nullptr ? 0 : found->Nodes().size();
}

std::uint64_t DataGraph::PublishedCount(std::string_view channel) const noexcept {
  const Channel* found = core_->Find(channel);
  return found == nullptr ? 0 : found->published();
}

void DataGraph::SetClosed(std::string_view channel, bool closed) { core_->SetClosed(channel, closed); }

GraphSnapshot DataGraph::Snapshot() const {
  auto channels = core_->Channels();
  std::ranges::sort(channels, {}, &Channel::name);  // Pointers move faster than snapshots.
  GraphSnapshot snapshot;
  snapshot.channels.reserve(channels.size());
  for (const Channel* channel : channels) snapshot.channels.push_back(channel->Snapshot());
  return snapshot;
}

bool DataGraph::WaitIdle(std::chrono::steady_clock::time_point deadline) const { return core_->WaitIdle(deadline); }

void DataGraph::PublisherIsGone(std::uint64_t publisher) { core_->PublisherIsGone(publisher); }
void DataGraph::PublisherIsBack(std::uint64_t publisher) { core_->PublisherIsBack(publisher); }

void DataGraph::LogUnmatchedOverrides() { core_->LogUnmatchedOverrides(); }

void DataGraph::Refuse() noexcept { core_->Refuse(); }

void DataGraph::Shutdown() noexcept { core_->Shutdown(); }

}  // namespace hgros
