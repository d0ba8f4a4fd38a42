#include "session/carriers.hpp"

#include <type_traits>
#include <utility>

#include "hgros/base/error.hpp"

namespace hgros {
namespace {

void AddTo(JoinedOutbound& joined, Transport& transport, CarrierKind /*kind*/) { joined.Add(transport); }
void AddTo(JoinedInbound& joined, Transport& transport, CarrierKind kind) { joined.Add(transport, kind); }

}  // namespace

// Before a message of the peer's has come over this carrier.
void Carriers::Ear::OnPeerCame(const PeerInfo& peer) noexcept {
  if (carriers_.peers_.Came(peer, kind_)) carriers_.BeginMove(peer.id);
}

void Carriers::Ear::OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept {
  const bool free = carriers_.peers_.Gone(peer, kind_, reason);
  carriers_.EndMove(peer.id, kind_);
  if (free) {
    carriers_.AskAgain(kind_ == CarrierKind::kShm ? CarrierKind::kZmq : CarrierKind::kShm);
  }
  // It may come back that way, or never.
  if (kind_ == CarrierKind::kShm) carriers_.AwaitSharedMemory(peer.id, peer.process, peer.pid);
}

void Carriers::Ear::OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view what) noexcept {
  carriers_.listener_.OnTypeMismatch(channel, peer, what);
}

void Carriers::Ear::OnClockExchange(const PeerInfo& peer, const ClockExchange& exchange) noexcept {
  if (!carriers_.IsOnThisHost(peer.id)) carriers_.listener_.OnClockExchange(peer, exchange);
}

bool Carriers::IsOnThisHost(SessionId peer) const {
  return peers_.IsFound(peer) || peers_.IsReached(peer, CarrierKind::kShm);
}

Carriers::Carriers(CarrierOptions options, TransportListener& listener, Log& log)
    : listener_(listener),
      log_(log),
      options_(std::move(options)),
      peers_(listener, log, options_.rules, options_.registry.has_value(),
             AnnouncementOfThisProcess(options_.zmq.session, 0).host),
      own_(AnnouncementOfThisProcess(options_.zmq.session, 0)),
      ruled_(!options_.rules.empty()) {
  options_.zmq.takes = [this](SessionId peer, std::string_view channel) {
    return peers_.Take(peer, channel, CarrierKind::kZmq);
  };
  own_.process = options_.zmq.process;
  own_.only = options_.only;
  if (options_.shm) OpenShm();
  // Before endpoints are bound: who finds us there can find us in the registry as well.
  if (options_.registry) LookOnHost();
  if (!options_.zmq.publish.empty() || !options_.zmq.subscribe.empty()) Zmq();
  if (options_.beacon) LookOnNetwork();
}

Carriers::~Carriers() { Close(0); }

void Carriers::Close(int linger_ms) noexcept {
  std::unique_ptr<Discovery> registry;
  std::unique_ptr<Discovery> beacon;
  {
    const std::scoped_lock lock(announcing_);
    registry = std::move(registry_);
    beacon = std::move(beacon_);
  }
  registry.reset();  // Nobody comes any more.
  beacon.reset();
  if (shm_) shm_->Close(linger_ms);
  if (ZmqTransport* const zmq = this->zmq()) zmq->Close(linger_ms);
}

CarrierSet Carriers::RuleOf(const std::string& channel) const {
  const auto rule = options_.rules.find(channel);
  return rule == options_.rules.end() ? CarrierSet{} : rule->second;
}

ZmqTransport& Carriers::Zmq() {
  if (owned_zmq_) return *owned_zmq_;
  owned_zmq_ = MakeZmqTransport(options_.zmq, zmq_ear_, log_);
  zmq_.store(owned_zmq_.get(), std::memory_order_release);
  {
    const std::scoped_lock lock(lists_);
    const auto join = [this](auto& list) {
      for (const auto& entry : list) {
        if (const auto joined = entry.lock(); joined && RuleOf(joined->channel()).zmq) {
          AddTo(*joined, *owned_zmq_, CarrierKind::kZmq);
        }
      }
    };
    join(outbound_);
    join(inbound_);
  }
  Announce();
  return *owned_zmq_;
}

void Carriers::AddPublishEndpoint(const PublishEndpoint& endpoint) {
  Zmq().AddPublishEndpoint(endpoint);
  Announce();
}

void Carriers::AddSubscribeEndpoint(const SubscribeEndpoint& endpoint) {
  ZmqTransport& zmq = Zmq();
  if (lan_) lan_->Configure(endpoint.endpoint);
  try {
    zmq.AddSubscribeEndpoint(endpoint);
  } catch (const Error&) {
    if (lan_) lan_->Release(endpoint.endpoint);
    throw;
  }
}

bool Carriers::RemoveSubscribeEndpoint(const std::string& endpoint) {
  const bool removed = zmq() != nullptr && zmq()->RemoveSubscribeEndpoint(endpoint);
  if (removed && lan_) lan_->Release(endpoint);
  return removed;
}

template <class Joined>
void Carriers::Join(std::vector<std::weak_ptr<Joined>>& list, const std::shared_ptr<Joined>& joined) {
  const CarrierSet rule = RuleOf(joined->channel());
  {
    const std::scoped_lock lock(lists_);
    std::erase_if(list, [](const auto& entry) { return entry.expired(); });
    list.push_back(joined);
    if constexpr (std::is_same_v<Joined, JoinedInbound>) {
      for (const std::uint64_t peer : moving_) MoveChannel(*joined, SessionId{peer});
    }
  }
  if (shm_ && rule.shared_memory) AddTo(*joined, *shm_, CarrierKind::kShm);
  if (owned_zmq_ && rule.zmq) AddTo(*joined, *owned_zmq_, CarrierKind::kZmq);
  if (!shm_ && !rule.zmq) {
    log_.WriteLimited(LogLevel::kWarning, "no shared memory " + joined->channel(),
                      "Channel \"" + joined->channel() +
                          "\" stays in this process: its `carriers` allow shared memory only, and this session shares "
                          "none. Let it find others of this host (discovery: local), or allow zmq.");
  }
  SayLaterWhatCannotPass();
}

std::shared_ptr<JoinedOutbound> Carriers::Advertise(const std::string& channel, const TypeInfo& type,
                                                    OutboundSource& source) {
  auto joined = std::make_shared<JoinedOutbound>(
      channel, type, source,
      [this](SessionId subscriber, std::function<void()> give_up) { AwaitSubscriber(subscriber, std::move(give_up)); });
  Join(outbound_, joined);
  {
    const std::scoped_lock lock(announcing_);
    Own(channel, type).publishes = true;
  }
  Announce();
  return joined;
}

std::shared_ptr<JoinedInbound> Carriers::Subscribe(const std::string& channel, const TypeInfo& type,
                                                   const Demand& demand, InboundSink& sink) {
  auto joined = std::make_shared<JoinedInbound>(channel, type, demand, sink, [this, channel](SessionId peer) {
    options_.later({}, [this, channel, peer] {
      peers_.Moved(peer, channel);
      AskAgain(CarrierKind::kZmq);  // It is let go of.
    });
  });
  Join(inbound_, joined);
  {
    const std::scoped_lock lock(announcing_);
    ChannelAnnouncement& entry = Own(channel, type);
    entry.subscribes = true;
    entry.lossless = demand.lossless;
  }
  Announce();
  return joined;
}

void Carriers::AskAgain(CarrierKind kind) noexcept {
  if (kind == CarrierKind::kShm && shm_) shm_->AskAgain();
  if (kind == CarrierKind::kZmq && zmq() != nullptr) zmq()->AskAgain();
}

TransportStats Carriers::stats() const {
  TransportStats sum;
  const auto add = [&sum](const TransportStats& stats) {
    for (std::size_t i = 0; i < sum.faults.size(); ++i) sum.faults[i] += stats.faults[i];
    sum.repeats += stats.repeats;
  };
  if (shm_) add(shm_->stats());
  if (zmq() != nullptr) add(zmq()->stats());
  return sum;
}

}  // namespace hgros
