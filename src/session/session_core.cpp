#include "session/session_core.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/clock/time.hpp"

namespace hgros {
namespace {

constexpr int kLingerMs = 500;
// A node that nobody has made so long after the session is perhaps a slip of the pen in the configuration.
constexpr auto kTimeForNodes = std::chrono::seconds(5);

std::string ProgramName() {
  std::ifstream file("/proc/self/comm");
  std::string name;
  std::getline(file, name);
  return name.empty() ? "hgros" : name;
}

ChannelList ListOf(const EndpointConfig& endpoint) {
  if (endpoint.all_channels) return std::nullopt;
  return endpoint.channels;
}

// The list with or without the channel; a list of all stays one, since what it leaves out cannot be written down.
void Allow(EndpointConfig& endpoint, std::string_view channel, bool allowed) {
  auto& list = endpoint.channels;
  const auto place = std::lower_bound(list.begin(), list.end(), channel);
  const bool there = place != list.end() && *place == channel;
  if (allowed && !there) list.emplace(place, channel);
  if (!allowed && there) list.erase(place);
}

void RequireList(const EndpointConfig& endpoint, std::string_view channel) {
  if (!endpoint.all_channels) return;
  throw Error("The endpoint " + endpoint.endpoint + " lets every channel pass, so \"" + std::string(channel) +
                  "\" cannot be taken from its list.",
              {}, "Give the endpoint a list of channels in its configuration.");
}

// Nothing: the session neither finds nor is found by others of this host.
std::optional<std::string> DomainOf(const Config& config) {
  const char* const environment = std::getenv("HGROS_DOMAIN");
  const bool set = environment != nullptr && *environment != '\0';
  const std::string domain = set ? environment : config.discovery.domain;
  if (!config.discovery.local || domain == kNoDomain) return std::nullopt;
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
      domain_(DomainOf(config_)) {
  alive_->core = this;
  GraphOptions graph_options;
  graph_options.threads = config_.threads;
  graph_options.overrides = config_.nodes;
  graph_options.publisher = publisher_;
  graph_ = std::make_unique<DataGraph>(std::move(graph_options), log_);
  for (const std::string& channel : config_.closed_channels) graph_->SetClosed(channel, true);
  events_ = graph_->Advertise<PeerEvent>(kPeerEventsChannel);
  if (!config_.nodes.empty()) {
    errands_.emplace();
    errands_->PostIn(kTimeForNodes, [this] { graph_->SayUntakenNames(); });
  }
  if (!config_.publishers.empty() || !config_.subscribers.empty()) Reach();
}

// Callbacks in flight may still use the session, so its members stay until the graph has waited for them.
Session::Core::~Core() {
  graph_->SayUntakenNames();
  graph_->Refuse();
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
  }
  Notify();
  for (const auto& inlet : inlets) inlet->Detach();
  if (carriers_) carriers_->Close(kLingerMs);  // May still say that peers have gone, which is an errand.
  for (const auto& outlet : outlets) outlet->Detach();
  graph_->Shutdown();
  errands_.reset();
}

void Session::Core::RequireOpen() const {
  if (closing_) throw Error("The session is shutting down.");
}

Carriers& Session::Core::Reach() {
  RequireOpen();
  if (carriers_) return *carriers_;
  if (!errands_) errands_.emplace();
  carriers_ = std::make_unique<Carriers>(OptionsForCarriers(), *this, *log_);
  for (auto& [name, outlet] : outlets_) outlet->Join(*carriers_);
  for (auto& [name, inflow] : inflows_) {
    if (inflow.wanted.empty() || inflow.joined || inflow.busy) continue;
    inflow.inlet->Join(*carriers_, Combine(inflow.wanted));
    inflow.joined = true;
  }
  return *carriers_;
}

CarrierOptions Session::Core::OptionsForCarriers() {
  CarrierOptions options;
  ZmqOptions& zmq = options.zmq;
  zmq.session = id_;
  zmq.process = name_;
  for (const EndpointConfig& endpoint : config_.publishers) {
    zmq.publish.push_back({endpoint.endpoint, ListOf(endpoint)});
  }
  for (const EndpointConfig& endpoint : config_.subscribers) {
    const auto key = config_.security.servers.find(endpoint.endpoint);
    zmq.subscribe.push_back(
        {endpoint.endpoint, ListOf(endpoint), key == config_.security.servers.end() ? std::string() : key->second});
  }
  zmq.heartbeat = std::chrono::milliseconds(config_.heartbeat_ms);
  zmq.peer_timeout = std::chrono::milliseconds(config_.peer_timeout_ms);
  zmq.peer_queue_bytes = config_.peer_queue_bytes;
  zmq.plain_queue_bytes = config_.peer_queue_bytes;
  zmq.linger = std::chrono::milliseconds(kLingerMs);
  if (config_.security.enabled()) {
    zmq.security =
        ZmqSecurity{{config_.security.public_key, config_.security.secret_key}, config_.security.allowed_clients};
  }
  if (domain_) {
    ShmOptions& shm = options.shm.emplace();
    shm.session = id_;
    shm.process = name_;
    shm.wait = config_.shared_memory.wait;
    shm.spin = std::chrono::microseconds(config_.shared_memory.spin_us);
    shm.limit_bytes = config_.shared_memory.limit_bytes;
    shm.heartbeat = zmq.heartbeat;
    shm.peer_timeout = zmq.peer_timeout;
    shm.peer_queue_bytes = zmq.peer_queue_bytes;
    options.registry.emplace().domain = *domain_;
  }
  options.later = [this](std::chrono::nanoseconds delay, std::function<void()> errand) {
    errands_->PostIn(delay, std::move(errand));
  };
  return options;
}

Channel& Session::Core::Open(std::string_view name, const TypeInfo& type, const CallSite& where) {
  return graph_->Open(name, type, where);
}

Channel& Session::Core::OpenAny(std::string_view name, const TypeInfo& type, const CallSite& where) {
  Channel& channel = graph_->Open(name, type, where);
  if (DataGraph::HasOutlet(channel)) return channel;
  const std::scoped_lock lock(mutex_);
  if (DataGraph::HasOutlet(channel) || closing_) return channel;
  auto outlet = std::make_shared<ChannelOutlet>(
      std::string(name), type, publisher_, log_,
      OutletEvents{[&channel] { DataGraph::NotifyRoom(channel); }, [this] { Notify(); },
                   [this, channel_name = std::string(name)] { return SayIfItCannotLeave(channel_name); }});
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

// A slip of the pen in a white list is otherwise nothing but silence. A sentence, or nothing if the channel may pass.
std::string Session::Core::Confined(std::string_view channel, const std::vector<EndpointConfig>& endpoints, Way way) {
  std::vector<std::string> listed;
  for (const EndpointConfig& endpoint : endpoints) {
    if (endpoint.all_channels || std::binary_search(endpoint.channels.begin(), endpoint.channels.end(), channel)) {
      return {};
    }
    listed.insert(listed.end(), endpoint.channels.begin(), endpoint.channels.end());
  }
  if (endpoints.empty()) return {};
  const std::string nearest = NearestName(channel, listed);
  return "Channel \"" + std::string(channel) +
         (way == Way::kOut ? "\" is published, but does not leave this process: no publisher"
                           : "\" is subscribed to, but nothing enters this process: no subscriber") +
         " endpoint has it in its list of channels." +
         (nearest.empty() ? std::string() : " Did you mean \"" + nearest + "\"?");
}

// Part of a publish, so it must not wait; false if it could not look.
bool Session::Core::SayIfItCannotLeave(const std::string& channel) {
  std::string confined;
  {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock) return false;
    confined = Confined(channel, config_.publishers, Way::kOut);
  }
  if (!confined.empty()) log_->Write(LogLevel::kInfo, confined);
  return true;
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

Subscription Session::Core::SubscribeGraph(Channel& channel, Invoke invoke, AnyCallback callback, NodeOptions options) {
  Subscription subscription =
      graph_->Subscribe(channel, invoke, std::move(callback), WithChannelConfig(channel, std::move(options)));
  Notify();
  return subscription;
}

Subscription Session::Core::SubscribeAny(Channel& channel, Invoke invoke, AnyCallback callback, NodeOptions options) {
  Subscription subscription = SubscribeGraph(channel, invoke, std::move(callback), std::move(options));
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
          channel, DataGraph::TypeOfChannel(channel), log_, [this] { Notify(); },
          [this](ChannelInlet::Errand errand) { errands_->Post(std::move(errand)); });
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

// The predicate takes other locks, so it is asked outside this one.
template <class Predicate>
bool Session::Core::WaitUntil(std::chrono::nanoseconds timeout, Predicate predicate) const {
  const auto deadline = DeadlineIn(timeout);
  for (;;) {
    std::unique_lock lock(changed_mutex_);
    const std::uint64_t seen = changes_;
    lock.unlock();
    if (predicate()) return true;
    if (closing_) return false;
    lock.lock();
    if (!changed_.wait_until(lock, deadline, [&] { return changes_ != seen; })) return predicate();
  }
}

bool Session::Core::WaitForSubscribers(std::string_view channel, std::size_t count,
                                       std::chrono::nanoseconds timeout) const {
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

void Session::Core::AllowPublishing(std::string_view channel, bool allowed) {
  RequireChannelName(channel);
  const std::scoped_lock lock(mutex_);
  for (EndpointConfig& endpoint : config_.publishers) {
    if (endpoint.all_channels && allowed) continue;
    RequireList(endpoint, channel);
    Allow(endpoint, channel, allowed);
    Reach().Zmq().SetPublishChannels(endpoint.endpoint, ListOf(endpoint));
  }
}

void Session::Core::AllowSubscribing(std::string_view channel, bool allowed) {
  RequireChannelName(channel);
  const std::scoped_lock lock(mutex_);
  for (EndpointConfig& endpoint : config_.subscribers) {
    if (endpoint.all_channels && allowed) continue;
    RequireList(endpoint, channel);
    Allow(endpoint, channel, allowed);
    Reach().Zmq().SetSubscribeChannels(endpoint.endpoint, ListOf(endpoint));
  }
}

void Session::Core::AddPublisherEndpoint(const EndpointConfig& endpoint) {
  const std::scoped_lock lock(mutex_);
  Reach().Zmq().AddPublishEndpoint({endpoint.endpoint, ListOf(endpoint)});
  config_.publishers.push_back(endpoint);
}

void Session::Core::AddSubscriberEndpoint(const EndpointConfig& endpoint) {
  const std::scoped_lock lock(mutex_);
  const auto key = config_.security.servers.find(endpoint.endpoint);
  Reach().Zmq().AddSubscribeEndpoint(
      {endpoint.endpoint, ListOf(endpoint), key == config_.security.servers.end() ? std::string() : key->second});
  config_.subscribers.push_back(endpoint);
}

void Session::Core::RemoveSubscriberEndpoint(std::string_view endpoint) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(config_.subscribers, [&](const EndpointConfig& one) { return one.endpoint == endpoint; });
  ZmqTransport* const zmq = carriers_ ? carriers_->zmq() : nullptr;
  if (zmq == nullptr || !zmq->RemoveSubscribeEndpoint(std::string(endpoint))) {
    throw Error("There is no subscriber endpoint " + std::string(endpoint) + ".");
  }
}

std::vector<std::string> Session::Core::PublisherEndpoints() const {
  const std::scoped_lock lock(mutex_);
  const ZmqTransport* const zmq = carriers_ ? carriers_->zmq() : nullptr;
  return zmq != nullptr ? zmq->BoundEndpoints() : std::vector<std::string>();
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
  const std::scoped_lock lock(mutex_);
  for (const auto& [name, outlet] : outlets_) {
    ChannelTraffic traffic;
    traffic.channel = name;
    outlet->AddTo(traffic);
    if (const auto entry = inflows_.find(name); entry != inflows_.end()) entry->second.inlet->AddTo(traffic);
    snapshot.traffic.push_back(std::move(traffic));
  }
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
  log_->Write(LogLevel::kInfo, "Session " + peer.id.ToString() + " (" + peer.process + " on " + peer.host +
                                   (peer.endpoint.empty() ? ") has connected" : ") answers at " + peer.endpoint) +
                                   ", over " + peer.carrier + ".");
  errands_->Post([this, id = peer.id.value] { graph_->PublisherIsBack(id); });
  PublishEvent({PeerEvent::Kind::kCame, peer, {}, {}});
}

void Session::Core::OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept {
  errands_->Post([this, id = peer.id.value] { graph_->PublisherIsGone(id); });  // In order with its return.
  log_->Write(LogLevel::kInfo, "Session " + peer.id.ToString() + " (" + peer.process + " on " + peer.host +
                                   ") is gone: " + std::string(reason));
  PublishEvent({PeerEvent::Kind::kGone, peer, {}, std::string(reason)});
}

// `what` names the channel and both types.
void Session::Core::OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view what) noexcept {
  std::string sentence = "Nothing passes between this session and " + peer.id.ToString() + " (" + peer.process +
                         ") on a channel that they use with different types, " + std::string(what) +
                         ". Build both programs with one type, or give one of them another channel name.";
  log_->Write(LogLevel::kError, sentence);
  PublishEvent({PeerEvent::Kind::kTypeMismatch, peer, std::string(channel), std::move(sentence)});
}

}  // namespace hgros
