#include "session/session_core.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/log_ending.hpp"
#include "hgros/base/names.hpp"
#include "hgros/base/readable_text.hpp"
#include "hgros/base/session_name.hpp"
#include "hgros/clock/system_clocks.hpp"
#include "hgros/clock/time.hpp"
#include "session/clock_follower.hpp"

namespace hgros {
namespace {

constexpr std::string_view kLibraryPrefix = "hgros/";

// If a configured node or channel does not exist after this time, its name may be misspelled.
constexpr auto kTimeForNames = std::chrono::seconds(5);

std::string ProgramName() {
  std::ifstream file("/proc/self/comm");
  std::string name;
  std::getline(file, name);
  return name.empty() ? "hgros" : Readable(name);
}

std::string NameOf(std::string given) {
  if (given.empty()) return ProgramName();
  if (IsReadable(given)) return given;
  throw Error(
      "The session name \"" + Readable(given) + "\" cannot be used: it has control characters, or is not UTF-8.", {},
      "Use visible UTF-8 text.");
}

// Empty if the session neither discovers others nor is discovered.
std::optional<std::string> DomainOf(const Config& config) {
  const char* const environment = std::getenv("HGROS_DOMAIN");
  const bool set = environment != nullptr && *environment != '\0';
  const std::string domain = set ? environment : config.discovery.domain;
  if ((!config.discovery.local && !config.discovery.lan) || domain == kNoDomain) return std::nullopt;
  if (!IsDomain(domain)) {
    throw Error(
        "\"" + domain + "\" cannot name a domain" + (set ? "; HGROS_DOMAIN sets it." : "."), {},
        "Use 1 to 64 letters, digits, '_', '-' and '.', not beginning with a '.', or \"none\" for no discovery.");
  }
  return domain;
}

Demand DemandFor(const Queue& queue) {
  Demand demand;
  demand.lossless = queue.lossless();
  const auto depth = static_cast<std::uint32_t>(std::min<std::size_t>(queue.depth(), 1U << 20));
  demand.queue_depth = depth;
  if (queue.lossless()) {
    demand.credit_messages = depth;
    demand.credit_bytes = std::min<std::uint64_t>(queue.limit_bytes(), demand.credit_bytes);
  }
  return demand;
}

std::shared_ptr<Clock> ClockOf(std::shared_ptr<Clock> given, std::shared_ptr<Clock> followed,
                               const std::shared_ptr<Log>& log) {
  if (given) return given;
  if (followed) return followed;
  return std::make_shared<SystemClock>([log](LogLevel level, std::string_view text) { log->Write(level, text); });
}

NodeOptions WithQueueOf(const Config& config, const Channel& channel, NodeOptions options) {
  const auto entry = config.channels.find(DataGraph::NameOf(channel));
  if (entry != config.channels.end() && entry->second.queue) options.queue = *entry->second.queue;
  return options;
}

}  // namespace

SessionCore::SessionCore(Config config, SessionOptions options)
    : config_(std::move(config)),
      id_(SessionId::Random()),
      name_(NameOf(std::move(options.name))),
      publisher_{id_.value, static_cast<std::uint64_t>(WallNow().nanoseconds), 0},
      log_(std::make_shared<Log>(std::move(options.log))),
      domain_(DomainOf(config_)),
      host_clocks_(std::make_shared<HostClocks>(std::move(options.wall))),
      followed_clock_(config_.simulated_time && !options.clock ? std::make_shared<FollowingClock>() : nullptr),
      clock_(ClockOf(std::move(options.clock), followed_clock_, log_)),
      outbound_(publisher_, log_, host_clocks_),
      inbound_(std::make_shared<InboundChannels>(
          InboundChannels::Means{log_, host_clocks_, [this] { changes_.Notify(); },
                                 [this](std::function<void()> errand) { errands_->Post(std::move(errand)); },
                                 [this](const std::string& misused, const PeerInfo& from, const std::string& what) {
                                   OnTypeMismatch(misused, from, what);
                                 }})) {
  GraphOptions graph_options;
  graph_options.threads = config_.threads;
  graph_options.overrides = config_.nodes;
  graph_options.publisher = publisher_;
  graph_ = std::make_unique<DataGraph>(std::move(graph_options), log_);
  GraphEnding(*graph_).SetOnExit([this] { LeaveAtExit(); });
  timers_.emplace(clock_, *graph_, log_);
  for (const std::string& channel : config_.closed_channels) graph_->SetClosed(channel, true);
  events_.emplace(SessionName(name_, getpid()), *graph_, log_);
  services_ = std::make_shared<Services>(static_cast<ServicePlace&>(*this), id_, log_);
  const auto own = [this] {
    const std::scoped_lock lock(mutex_);
    return OwnChannels();
  };
  const auto connected = [this](const std::string& channel) {
    const auto outlet = outbound_.Find(channel);
    return inbound_->PublisherCount(channel) > 0 || (outlet && outlet->subscriber_count() > 0);
  };
  misspelled_.emplace(MisspelledNames::Means{*graph_, log_, own, [this] { return Channels(); }, connected, Later()});
  const bool names_channels = MisspelledNames::AreIn(config_);
  if (!config_.nodes.empty() || names_channels || followed_clock_) errands_.emplace(log_);
  if (!config_.nodes.empty()) errands_->PostIn(kTimeForNames, [this] { graph_->LogUnmatchedOverrides(); });
  if (names_channels) errands_->PostIn(kTimeForNames, [this] { misspelled_->SayUnused(this->config()); });
  if (!config_.publishers.empty() || !config_.subscribers.empty()) EnsureTransports();
  if (!followed_clock_) return;
  clock_nodes_ =
      ClockFollower::Follow(followed_clock_, *graph_, log_, *errands_,
                            [this](Channel& channel, const TypeInfo& type, AnyCallback callback, NodeOptions node) {
                              return SubscribeAny(channel, type, Invoke::kSerial, std::move(callback), std::move(node));
                            });
}

// Callbacks in flight may still use the session, so its members stay until the graph has waited for them.
SessionCore::~SessionCore() {
  graph_->LogUnmatchedOverrides();
  misspelled_->SayUnused(config());
  services_->Refuse();
  graph_->Refuse();
  clock_nodes_.clear();
  {
    const std::scoped_lock lock(mutex_);
    ends_waits_ = true;
    closing_ = true;  // From here on no wiring changes.
  }
  outbound_.Close();
  changes_.Notify();
  const auto left = outbound_.AwaitSent(kLinger, std::chrono::milliseconds(config_.peer_timeout_ms), changes_);
  inbound_->Close();
  if (steering_) steering_->End();
  if (bridge_) bridge_->Close(left.linger_ms, left.at_most_ms);  // May still post errands: events of peers that go.
  outbound_.Detach();
  if (reports_) reports_->Detach();
  timers_->Stop();
  graph_->Shutdown();
  services_->Close();
  if (errands_) errands_->End();  // Not reset: errands in flight post others.
  inbound_->Drop();               // Subscriptions may keep it longer.
  LogEnding(*log_).WriteHeldBack();
}

bool SessionCore::TakesWiring() const {
  if (closing_ && ends_waits_) throw Error("The session is shutting down.");
  return !closing_;
}

Channel& SessionCore::OpenAny(std::string_view name, const TypeInfo& type, const CallSite& where) {
  if (name.starts_with(kLibraryPrefix)) {
    throw Error("Channel \"" + std::string(name) + "\" belongs to the library: a program cannot publish on it.",
                {where.ToString()}, "Use a name that does not begin with \"" + std::string(kLibraryPrefix) + "\".");
  }
  Channel& channel = graph_->Open(name, type, where);
  if (DataGraph::HasOutlet(channel)) return channel;
  bool open_to_others = false;
  {
    const std::scoped_lock lock(mutex_);
    if (closing_) return channel;
    if (domain_) EnsureTransports();
    open_to_others = bridge_ != nullptr;
  }
  const auto events = [&] {
    return OutletEvents{[&channel] { DataGraph::NotifyRoom(channel); }, [this] { changes_.Notify(); },
                        [this, channel_name = std::string(name)] { return SayIfItCannotLeave(channel_name); }};
  };
  const auto wire = [&](const std::shared_ptr<ChannelOutlet>& outlet) {
    if (const auto entry = config_.channels.find(name); entry != config_.channels.end() && entry->second.latched) {
      graph_->Latch(channel, *entry->second.latched);
      outlet->Latch(*entry->second.latched);
    }
    graph_->SetOutlet(channel, outlet);  // From now on other threads publish through it.
  };
  outbound_.Open(std::string(name), type, events, wire);
  if (open_to_others) misspelled_->Note(std::string(name));
  return channel;
}

void SessionCore::Latch(Channel& channel, std::size_t count) {
  if (count == 0) return;
  graph_->Latch(channel, count);
  if (const auto outlet = outbound_.Find(DataGraph::NameOf(channel))) outlet->Latch(count);
}

Block SessionCore::LoanBlock(std::string_view channel, std::size_t size_bytes) {
  const auto outlet = outbound_.Find(channel);
  auto block = outlet ? outlet->Loan(size_bytes) : std::nullopt;
  return block ? std::move(*block) : Block::Allocate(size_bytes);
}

Subscription SessionCore::SubscribeGraph(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                                         NodeOptions options) {
  Subscription subscription =
      graph_->Subscribe(channel, type, invoke, std::move(callback), WithQueueOf(config_, channel, std::move(options)));
  changes_.Notify();
  return subscription;
}

Subscription SessionCore::SubscribeAny(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                                       NodeOptions options) {
  const std::string& name = DataGraph::NameOf(channel);
  const auto expected = InboundChannels::Expect(inbound_, name);
  Subscription subscription = SubscribeGraph(channel, type, invoke, std::move(callback), std::move(options));
  std::string confined;
  bool open_to_others = false;
  {
    const std::scoped_lock lock(mutex_);
    if (domain_ && !closing_) EnsureTransports();
    open_to_others = bridge_ != nullptr;
    if (said_confined_.insert(name).second) {
      confined = DescribeConfined(name, config_.subscribers, Way::kIn, OutermostPlace(config_, domain_.has_value()));
    }
  }
  subscription.Attach(InboundChannels::Add(inbound_, channel, type, DemandFor(subscription.stats().queue)));
  if (!confined.empty()) log_->Write(LogLevel::kDebug, confined);
  if (open_to_others) misspelled_->Note(name);
  return subscription;
}

// A caller that waits for subscribers is about to publish, so the channel is announced.
bool SessionCore::WaitForSubscribers(std::string_view channel, std::size_t count, std::chrono::nanoseconds timeout) {
  if (graph_->NodeCount(channel) > 0 && !closing_ && !channel.starts_with(kLibraryPrefix)) {
    const TypeInfo& type = DataGraph::TypeOfChannel(graph_->Open(channel, AnyType(), CallSite::Current()));
    if (type.encoding != Encoding::kNone) (void)OpenAny(channel, type, CallSite::Current());
  }
  return WaitUntil(timeout, [&] {
    const auto outlet = outbound_.Find(channel);
    return graph_->NodeCount(channel) + (outlet ? outlet->subscriber_count() : 0) >= count;
  });
}

bool SessionCore::WaitForPublishers(std::string_view channel, std::size_t count,
                                    std::chrono::nanoseconds timeout) const {
  return WaitUntil(timeout, [&] { return inbound_->PublisherCount(channel) >= count; });
}

std::vector<PeerInfo> SessionCore::Peers() const {
  const std::scoped_lock lock(mutex_);
  return bridge_ ? bridge_->Peers() : std::vector<PeerInfo>();
}

std::optional<ClockOffset> SessionCore::OffsetTo(SessionId peer) const {
  if (peer == id_) return ClockOffset{};
  const std::scoped_lock lock(mutex_);
  return bridge_ && bridge_->IsOnThisHost(peer) ? ClockOffset{} : host_clocks_->OffsetTo(peer);
}

SessionSnapshot SessionCore::Snapshot() const {
  SessionSnapshot snapshot;
  snapshot.id = id_;
  snapshot.name = name_;
  snapshot.graph = graph_->Snapshot();
  snapshot.services = services_->Snapshot();
  outbound_.AddTo(snapshot.traffic);
  inbound_->AddTo(snapshot.traffic);
  std::ranges::sort(snapshot.traffic, {}, &ChannelTraffic::channel);
  const std::scoped_lock lock(mutex_);
  if (bridge_) {
    snapshot.peers = bridge_->Peers();
    snapshot.transport = bridge_->stats();
  }
  Steering::AddTo(snapshot, steering_, config_, domain_.has_value(), OwnChannels().channels);
  return snapshot;
}

void SessionCore::OnPeerCame(const PeerInfo& peer) noexcept {
  errands_->Post([this, id = peer.id.value] { graph_->PublisherIsBack(id); });
  events_->ReportCame(*errands_, peer);
  changes_.Notify();
}

void SessionCore::OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept {
  services_->OnPeerGone(peer, reason);
  host_clocks_->Forget(peer.id);
  // Posted, to keep the order with PublisherIsBack().
  errands_->Post([this, id = peer.id.value] { graph_->PublisherIsGone(id); });
  events_->ReportGone(*errands_, peer, reason, closing_);
  changes_.Notify();
}

void SessionCore::OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view what) noexcept {
  services_->OnTypeMismatch(channel, peer, events_->ReportTypeMismatch(*errands_, peer, channel, what));
  changes_.Notify();
}

}  // namespace hgros
