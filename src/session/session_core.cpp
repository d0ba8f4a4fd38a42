#include "session/session_core.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/clock/system_clocks.hpp"
#include "hgros/clock/time.hpp"

namespace hgros {
namespace {

// A node that nobody has made so long after the session is perhaps a slip of the pen in the configuration.
constexpr auto kTimeForNodes = std::chrono::seconds(5);

constexpr std::string_view kOwnChannels = "hgros/";

std::string ProgramName() {
  std::ifstream file("/proc/self/comm");
  std::string name;
  std::getline(file, name);
  return name.empty() ? "hgros" : name;
}

// Nothing: the session neither finds others by itself nor is found by them.
std::optional<std::string> DomainOf(const Config& config) {
  const char* const environment = std::getenv("HGROS_DOMAIN");
  const bool set = environment != nullptr && *environment != '\0';
  const std::string domain = set ? environment : config.discovery.domain;
  if ((!config.discovery.local && !config.discovery.lan) || domain == kNoDomain) return std::nullopt;
  if (!IsDomain(domain)) {
    throw Error("\"" + domain + "\" cannot name a domain" + (set ? ", as HGROS_DOMAIN says." : "."), {},
                "Use 1 to 64 letters, digits, '_', '-' and '.', or \"none\" to be found by nobody.");
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

}  // namespace

// Belongs to one Subscription: ends its part of what the session asks of remote publishers.
class Session::Core::DemandTicket {
 public:
  DemandTicket(std::shared_ptr<Alive> alive, std::string channel, std::list<Demand>::iterator demand)
      : alive_(std::move(alive)), channel_(std::move(channel)), demand_(demand) {}
  DemandTicket(const DemandTicket&) = delete;
  DemandTicket& operator=(const DemandTicket&) = delete;
  ~DemandTicket() {
    const std::shared_lock lock(alive_->mutex);
    if (alive_->core != nullptr) alive_->core->Withdraw(channel_, demand_);
  }

 private:
  std::shared_ptr<Alive> alive_;
  std::string channel_;
  std::list<Demand>::iterator demand_;
};

Session::Core::Core(Config config, SessionOptions options)
    : config_(std::move(config)),
      id_(SessionId::Random()),
      name_(options.name.empty() ? ProgramName() : std::move(options.name)),
      publisher_{id_.value, static_cast<std::uint64_t>(WallNow().nanoseconds), 0},
      log_(std::make_shared<Log>(std::move(options.log))),
      domain_(DomainOf(config_)),
      host_clocks_(std::make_shared<HostClocks>(std::move(options.wall))),
      followed_clock_(config_.simulated_time && !options.clock ? std::make_shared<FollowingClock>() : nullptr),
      clock_(ClockOf(std::move(options.clock), followed_clock_, log_)) {
  alive_->core = this;
  GraphOptions graph_options;
  graph_options.threads = config_.threads;
  graph_options.overrides = config_.nodes;
  graph_options.publisher = publisher_;
  graph_ = std::make_unique<DataGraph>(std::move(graph_options), log_);
  timers_.emplace(clock_, *graph_, log_);
  for (const std::string& channel : config_.closed_channels) graph_->SetClosed(channel, true);
  events_ = graph_->Advertise<PeerEvent>(kPeerEventsChannel);
  channel_events_ = graph_->Advertise<ChannelsChanged>(kChannelEventsChannel);
  services_ = std::make_shared<Services>(static_cast<ServicePlace&>(*this), id_, log_);
  if (!config_.nodes.empty()) {
    errands_.emplace();
    errands_->PostIn(kTimeForNodes, [this] { graph_->SayUntakenNames(); });
  }
  if (!config_.publishers.empty() || !config_.subscribers.empty()) Reach();
  clock_nodes_ = FollowClock();
}

// Callbacks in flight may still use the session, so its members stay until the graph has waited for them.
Session::Core::~Core() {
  graph_->SayUntakenNames();
  services_->Refuse();
  graph_->Refuse();
  clock_nodes_.clear();
  {
    const std::unique_lock lock(alive_->mutex);
    alive_->core = nullptr;
  }
  std::vector<std::shared_ptr<ChannelInlet>> inlets;
  std::vector<std::shared_ptr<ChannelOutlet>> outlets;
  {
    const std::scoped_lock lock(mutex_);
    closing_ = true;  // From here on no wiring changes.
    for (auto& [name, inflow] : inflows_) inlets.push_back(inflow.inlet);
    for (auto& [name, outlet] : outlets_) outlets.push_back(outlet);
    outlets.insert(outlets.end(), service_outlets_.begin(), service_outlets_.end());
    if (snapshots_) outlets.push_back(snapshots_->outlet());
  }
  Notify();
  for (const auto& inlet : inlets) inlet->Detach();
  if (carriers_) carriers_->Close(kLingerMs);  // May still say that peers have gone, which is an errand.
  for (const auto& outlet : outlets) outlet->Detach();
  timers_->Stop();
  graph_->Shutdown();
  services_->Close();
  if (errands_) errands_->End();  // Not reset: errands in flight post others.
}

void Session::Core::RequireOpen() const {
  if (closing_) throw Error("The session is shutting down.");
}

Channel& Session::Core::Open(std::string_view name, const TypeInfo& type, const CallSite& where) {
  return graph_->Open(name, type, where);
}

Channel& Session::Core::OpenAny(std::string_view name, const TypeInfo& type, const CallSite& where) {
  Channel& channel = graph_->Open(name, type, where);
  if (DataGraph::HasOutlet(channel)) return channel;
  if (name.starts_with(kOwnChannels)) {
    throw Error("Channel \"" + std::string(name) + "\" is the library's own: a program cannot publish there.",
                {where.ToString()}, "Take a name that does not begin with \"" + std::string(kOwnChannels) + "\".");
  }
  const std::scoped_lock lock(mutex_);
  if (DataGraph::HasOutlet(channel) || closing_) return channel;
  auto outlet = std::make_shared<ChannelOutlet>(
      std::string(name), type, publisher_, log_,
      OutletEvents{[&channel] { DataGraph::NotifyRoom(channel); }, [this] { Notify(); },
                   [this, channel_name = std::string(name)] { return SayIfItCannotLeave(channel_name); }},
      host_clocks_);
  if (const auto entry = config_.channels.find(name); entry != config_.channels.end() && entry->second.latched) {
    graph_->Latch(channel, *entry->second.latched);
    outlet->Latch(*entry->second.latched);
  }
  if (domain_) Reach();
  if (carriers_) outlet->Join(*carriers_);
  outlets_.emplace(name, outlet);
  graph_->SetOutlet(channel, outlet);  // Last: from now on other threads publish through it.
  return channel;
}

void Session::Core::Latch(Channel& channel, std::size_t count) {
  if (count == 0) return;
  graph_->Latch(channel, count);
  const std::scoped_lock lock(mutex_);
  if (const auto outlet = outlets_.find(DataGraph::NameOf(channel)); outlet != outlets_.end()) {
    outlet->second->Latch(count);
  }
}

Block Session::Core::LoanBlock(std::string_view channel, std::size_t size_bytes) {
  std::shared_ptr<ChannelOutlet> outlet;
  {
    const std::scoped_lock lock(mutex_);
    if (const auto entry = outlets_.find(channel); entry != outlets_.end()) outlet = entry->second;
  }
  auto block = outlet ? outlet->Loan(size_bytes) : std::nullopt;
  return block ? std::move(*block) : Block::Allocate(size_bytes);
}

NodeOptions Session::Core::WithChannelConfig(const Channel& channel, NodeOptions options) const {
  const auto entry = config_.channels.find(DataGraph::NameOf(channel));
  if (entry != config_.channels.end() && entry->second.queue) options.queue = *entry->second.queue;
  return options;
}

Subscription Session::Core::SubscribeGraph(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                                           NodeOptions options) {
  Subscription subscription =
      graph_->Subscribe(channel, type, invoke, std::move(callback), WithChannelConfig(channel, std::move(options)));
  Notify();
  return subscription;
}

Subscription Session::Core::SubscribeAny(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                                         NodeOptions options) {
  Subscription subscription = SubscribeGraph(channel, type, invoke, std::move(callback), std::move(options));
  const Demand demand = DemandFor(subscription.stats().queue);
  const std::string& name = DataGraph::NameOf(channel);
  std::string confined;
  {
    const std::scoped_lock lock(mutex_);
    if (domain_ && !closing_) Reach();
    Inflow& inflow = inflows_[name];
    const auto place = inflow.wanted.insert(inflow.wanted.end(), demand);
    if (!inflow.inlet) {
      inflow.inlet = std::make_shared<ChannelInlet>(
          channel, log_, [this] { Notify(); },
          [this](ChannelInlet::Errand errand) { errands_->Post(std::move(errand)); },
          [this](const std::string& misused, const PeerInfo& from, const std::string& what) {
            OnTypeMismatch(misused, from, what);
          },
          host_clocks_);
    } else if (inflow.joined && !IsAnyType(type)) {
      errands_->Post([inlet = inflow.inlet] { inlet->CompareOffers(); });
    }
    if (inflow.joined) inflow.inlet->SetDemand(Combine(inflow.wanted));
    subscription.Attach(std::make_shared<DemandTicket>(alive_, name, place));
    if (said_confined_.insert(name).second) confined = Confined(name, config_.subscribers, Way::kIn);
  }
  Reconcile(name);
  if (!confined.empty()) log_->Write(LogLevel::kInfo, confined);
  return subscription;
}

void Session::Core::Withdraw(const std::string& channel, std::list<Demand>::iterator demand) {
  const std::scoped_lock lock(mutex_);
  Inflow& inflow = inflows_.at(channel);
  inflow.wanted.erase(demand);
  if (!inflow.wanted.empty()) {
    if (inflow.joined) inflow.inlet->SetDemand(Combine(inflow.wanted));
    return;
  }
  // Ending the inbound channel waits for its callbacks, which may themselves be ending subscriptions just now.
  if (errands_ && inflow.joined) errands_->Post([this, channel] { Reconcile(channel); });
}

void Session::Core::Reconcile(const std::string& channel) {
  std::unique_lock lock(mutex_);
  const auto entry = inflows_.find(channel);
  if (entry == inflows_.end() || entry->second.busy) return;
  Inflow& inflow = entry->second;
  inflow.busy = true;
  while (carriers_ && !closing_ && inflow.joined == inflow.wanted.empty()) {
    if (inflow.joined) {
      lock.unlock();
      inflow.inlet->Detach();
      lock.lock();
      inflow.joined = false;
      carriers_->Unannounce(channel);
    } else {
      inflow.inlet->Join(*carriers_, Combine(inflow.wanted));
      inflow.joined = true;
    }
  }
  inflow.busy = false;
}

// What satisfies all of them: lossless if one is, as much credit as the one with the least room among those allows.
Demand Session::Core::Combine(const std::list<Demand>& wanted) {
  Demand combined = wanted.front();
  for (const Demand& demand : wanted) {
    if (demand.lossless && !combined.lossless) {
      combined = demand;
    } else if (demand.lossless == combined.lossless && demand.lossless) {
      combined.credit_messages = std::min(combined.credit_messages, demand.credit_messages);
      combined.credit_bytes = std::min(combined.credit_bytes, demand.credit_bytes);
    } else if (demand.lossless == combined.lossless) {
      combined.queue_depth = std::max(combined.queue_depth, demand.queue_depth);
    }
  }
  return combined;
}

void Session::Core::Notify() noexcept {
  {
    const std::scoped_lock lock(changed_mutex_);
    ++changes_;
  }
  changed_.notify_all();
}

// Who waits for them is about to publish.
bool Session::Core::WaitForSubscribers(std::string_view channel, std::size_t count, std::chrono::nanoseconds timeout) {
  if (graph_->NodeCount(channel) > 0 && !closing_ && !channel.starts_with(kOwnChannels)) {
    const TypeInfo& type = DataGraph::TypeOfChannel(graph_->Open(channel, AnyType(), CallSite::Current()));
    if (type.encoding != Encoding::kNone) (void)OpenAny(channel, type, CallSite::Current());
  }
  return WaitUntil(timeout, [&] {
    const std::scoped_lock lock(mutex_);
    const auto outlet = outlets_.find(channel);
    return graph_->NodeCount(channel) + (outlet == outlets_.end() ? 0 : outlet->second->subscriber_count()) >= count;
  });
}

bool Session::Core::WaitForPublishers(std::string_view channel, std::size_t count,
                                      std::chrono::nanoseconds timeout) const {
  return WaitUntil(timeout, [&] {
    const std::scoped_lock lock(mutex_);
    const auto entry = inflows_.find(channel);
    return entry != inflows_.end() && entry->second.inlet->publisher_count() >= count;
  });
}

std::vector<PeerInfo> Session::Core::Peers() const {
  const std::scoped_lock lock(mutex_);
  return carriers_ ? carriers_->Peers() : std::vector<PeerInfo>();
}

Config Session::Core::config() const {
  const std::scoped_lock lock(mutex_);
  return config_;
}

SessionSnapshot Session::Core::Snapshot() const {
  SessionSnapshot snapshot;
  snapshot.id = id_;
  snapshot.name = name_;
  snapshot.graph = graph_->Snapshot();
  snapshot.services = services_->Snapshot();
  const std::scoped_lock lock(mutex_);
  for (const auto& [name, outlet] : outlets_) {
    ChannelTraffic traffic;
    traffic.channel = name;
    outlet->AddTo(traffic);
    if (const auto entry = inflows_.find(name); entry != inflows_.end()) entry->second.inlet->AddTo(traffic);
    snapshot.traffic.push_back(std::move(traffic));
  }
  for (const auto& [name, inflow] : inflows_) {
    if (outlets_.contains(name)) continue;
    ChannelTraffic traffic;
    traffic.channel = name;
    inflow.inlet->AddTo(traffic);
    snapshot.traffic.push_back(std::move(traffic));
  }
  std::ranges::sort(snapshot.traffic, {}, &ChannelTraffic::channel);
  if (carriers_) {
    snapshot.peers = carriers_->Peers();
    snapshot.transport = carriers_->stats();
  }
  return snapshot;
}

// Not on the carrier's thread: a node on this channel may run inline.
void Session::Core::PublishEvent(PeerEvent event) noexcept {
  errands_->Post([this, shared = std::make_shared<const PeerEvent>(std::move(event))] {
    if (events_(shared) == PublishStatus::kFull) {
      log_->WriteLimited(LogLevel::kWarning, "peer events", "A peer event was not delivered: a lossless node is full.");
    }
  });
  Notify();
}

void Session::Core::OnPeerCame(const PeerInfo& peer) noexcept {
  // The name of a pair's socket means nothing to anybody.
  const bool at = !peer.endpoint.empty() && peer.endpoint.find("://") != std::string::npos;
  log_->Write(LogLevel::kInfo, NameOf(peer) + " is reached through " + peer.carrier +
                                   (at ? " at " + peer.endpoint : std::string()) + ": " + peer.why + ".");
  errands_->Post([this, id = peer.id.value] { graph_->PublisherIsBack(id); });
  PublishEvent({PeerEvent::Kind::kCame, peer, {}, {}});
}

void Session::Core::OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept {
  services_->OnPeerGone(peer, reason);
  host_clocks_->Forget(peer.id);
  errands_->Post([this, id = peer.id.value] { graph_->PublisherIsGone(id); });  // In order with its return.
  log_->Write(LogLevel::kInfo,
              NameOf(peer) + (closing_ ? " is no longer reached: " : " is gone: ") + std::string(reason) + ".");
  PublishEvent({PeerEvent::Kind::kGone, peer, {}, std::string(reason)});
}

// `what` names the channel and both types.
void Session::Core::OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view what) noexcept {
  std::string sentence = "Nothing passes between this session and " + peer.id.ToString() + " (" + peer.process +
                         ") on a channel that they use with different types, " + std::string(what) +
                         ". Build both programs with one type, or give one of them another channel name.";
  log_->Write(LogLevel::kError, sentence);
  services_->OnTypeMismatch(channel, peer, sentence);
  PublishEvent({PeerEvent::Kind::kTypeMismatch, peer, std::string(channel), std::move(sentence)});
}

}  // namespace hgros
