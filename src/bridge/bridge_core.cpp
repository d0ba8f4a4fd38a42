#include "bridge/bridge_core.hpp"

#include <bit>
#include <type_traits>
#include <utility>

#include "bridge/transports.hpp"
#include "hgros/base/error.hpp"

namespace hgros {
namespace {

void AddTo(JoinedOutbound& joined, Transport& transport, TransportIndex /*index*/) { joined.Add(transport); }
void AddTo(JoinedInbound& joined, Transport& transport, TransportIndex index) { joined.Add(transport, index); }

TransportRules RulesIn(const std::map<std::string, TransportKeys, std::less<>>& keys, const TransportList& transports) {
  TransportRules rules;
  for (const auto& [channel, allowed] : keys) {
    const TransportSet rule = transports.SetOf(allowed);
    if (rule != transports.all()) rules.emplace(channel, rule);
  }
  return rules;
}

PeerInfo Self(const BridgeOptions& options) {
  Announcement own = AnnouncementOfThisProcess(options.zmq.session, 0);
  own.process = options.zmq.process;
  return InfoOf(own);
}

}  // namespace

// Must happen before a message of the peer comes over this transport.
void BridgeCore::Ear::OnPeerCame(const PeerInfo& peer) noexcept {
  if (const auto move = bridge_.peers_.Came(peer, transport_)) bridge_.BeginMove(peer.id, *move);
}

void BridgeCore::Ear::OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept {
  const bool free = bridge_.peers_.Gone(peer, transport_, reason);
  bridge_.EndMove(peer.id, transport_);
  if (free) bridge_.AskAgain();
  // The peer may come back over this transport, or never.
  if (bridge_.transports_.on_host().Has(transport_)) bridge_.pairs_.Await(peer.id);
}

void BridgeCore::Ear::OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view what) noexcept {
  bridge_.listener_.OnTypeMismatch(channel, peer, what);
}

void BridgeCore::Ear::OnClockExchange(const PeerInfo& peer, const ClockExchange& exchange) noexcept {
  if (!bridge_.IsOnThisHost(peer.id)) bridge_.listener_.OnClockExchange(peer, exchange);
}

bool BridgeCore::IsOnThisHost(SessionId peer) const {
  return peers_.IsFound(peer) || !peers_.ReachedBy(peer).In(transports_.on_host()).empty();
}

BridgeCore::BridgeCore(BridgeOptions options, TransportListener& listener, Log& log)
    : listener_(listener),
      log_(log),
      options_(std::move(options)),
      transports_(TransportsOf(options_)),
      rules_(RulesIn(options_.rules, transports_)),
      peers_(transports_, listener, log, rules_, options_.registry.has_value(), Self(options_)),
      open_(transports_),
      ruled_out_({transports_, peers_, announcer_, options_.later, log}, !rules_.empty()),
      pairs_({options_, transports_, open_, peers_, announcer_, log, [this] { AskAgain(); }}),
      announcer_(options_.zmq.session, options_.zmq.process, options_.only, options_.later, log) {
  for (TransportIndex i = 0; i < transports_.size(); ++i) ears_.emplace_back(*this, i);
  try {
    OpenAll();
  } catch (...) {
    Close(0, 0);  // Transports that are open already call this object until then.
    throw;
  }
}

void BridgeCore::OpenAll() {
  OpenOnHost();
  if (options_.registry) LookOnHost();
  for (TransportIndex i = 0; i < transports_.size(); ++i) {
    const TransportEntry& entry = transports_[i];
    if (entry.reach == TransportReach::kNetwork && entry.make && entry.opens_at_start) Open(i);
  }
  if (options_.beacon) LookOnNetwork();
}

BridgeCore::~BridgeCore() { Close(0, 0); }

void BridgeCore::Close(int linger_ms, int at_most_ms) noexcept {
  announcer_.Close();  // From here on no further session is found.
  open_.Close(linger_ms, at_most_ms);
}

void BridgeCore::Open(TransportIndex index) {
  if (open_[index] != nullptr) return;
  // So a session that finds this one at an endpoint also finds it in the registry.
  if (transports_[index].reach == TransportReach::kNetwork) AppearOnHost();
  const auto takes = [this, index](SessionId peer, std::string_view channel) {
    return peers_.Claim(peer, channel, index);
  };
  Transport& transport = open_.Open(index, takes, ears_[index], log_);
  if (!transport.place().empty()) announcer_.SetPlace(transports_[index].key, transport.place());
  {
    const std::scoped_lock lock(lists_);
    const auto join = [&](auto& list) {
      for (const auto& entry : list) {
        const auto joined = entry.lock();
        if (joined && transports_.SetOf(KeysFor(joined->channel())).Has(index)) AddTo(*joined, transport, index);
      }
    };
    join(outbound_);
    join(inbound_);
  }
  Announce();
}

ZmqTransport& BridgeCore::Zmq() {
  if (zmq() == nullptr) Open(*transports_.Find(kZmqKey));
  return *zmq();
}

void BridgeCore::AddPublishEndpoint(const PublishEndpoint& endpoint) {
  Zmq().AddPublishEndpoint(endpoint);
  Announce();
}

void BridgeCore::AddSubscribeEndpoint(const SubscribeEndpoint& endpoint) {
  ZmqTransport& zmq = Zmq();
  if (lan_) lan_->Configure(endpoint.endpoint);
  try {
    zmq.AddSubscribeEndpoint(endpoint);
  } catch (const Error&) {
    if (lan_) lan_->Release(endpoint.endpoint);
    throw;
  }
}

bool BridgeCore::RemoveSubscribeEndpoint(const std::string& endpoint) {
  const bool removed = zmq() != nullptr && zmq()->RemoveSubscribeEndpoint(endpoint);
  if (removed && lan_) lan_->Release(endpoint);
  return removed;
}

TransportKeys BridgeCore::KeysFor(const std::string& channel) const {
  const auto rule = options_.rules.find(channel);
  return rule == options_.rules.end() || !rules_.contains(channel) ? std::nullopt : rule->second;
}

void BridgeCore::WarnIfConfined(const std::string& channel, TransportSet rule) {
  for (TransportIndex i = 0; i < transports_.size(); ++i) {
    if (rule.Has(i) && (open_[i] != nullptr || !transports_[i].opens_at_start)) return;  // That one may open later.
  }
  log_.WriteLimited(LogLevel::kWarning, "confined " + channel,
                    "Channel \"" + channel + "\" stays in this process: its `transports` allow " +
                        transports_.NamesOf(rule) +
                        " only, which this session does not have. Let it find others of this host (discovery: local), "
                        "or allow zmq.");
}

template <class Joined>
void BridgeCore::Join(std::vector<std::weak_ptr<Joined>>& list, const std::shared_ptr<Joined>& joined) {
  const TransportSet rule = transports_.SetOf(KeysFor(joined->channel()));
  {
    const std::scoped_lock lock(lists_);
    // Only when the list has doubled, so that many channels are joined in linear time.
    if (std::has_single_bit(list.size())) std::erase_if(list, [](const auto& entry) { return entry.expired(); });
    list.push_back(joined);
    if constexpr (std::is_same_v<Joined, JoinedInbound>) {
      for (const SessionId peer : peers_.Moving()) MoveChannel(*joined, peer);
    }
  }
  for (TransportIndex i = 0; i < transports_.size(); ++i) {
    if (open_[i] != nullptr && rule.Has(i)) AddTo(*joined, *open_[i], i);
  }
  if (rule != transports_.all()) WarnIfConfined(joined->channel(), rule);
  ruled_out_.LookLater();
}

std::shared_ptr<JoinedOutbound> BridgeCore::Advertise(const std::string& channel, const TypeInfo& type,
                                                      OutboundSource& source) {
  auto joined = std::make_shared<JoinedOutbound>(
      channel, type, source, transports_.size(),
      [this](SessionId subscriber, JoinedOutbound::Abandon give_up) {
        AwaitSubscriber(subscriber, std::move(give_up));
      },
      log_);
  // Done before transports join: a partner on this host is left to the cheapest one.
  announcer_.Publishes(channel, type, KeysFor(channel));
  try {
    pairs_.OwnChanged(channel);
    Join(outbound_, joined);
  } catch (...) {
    EndPublishing(channel);
    throw;
  }
  Announce();
  return joined;
}

std::shared_ptr<JoinedInbound> BridgeCore::Subscribe(const std::string& channel, const TypeInfo& type,
                                                     const TypeInfo& announced, const Demand& demand,
                                                     InboundSink& sink) {
  announcer_.Subscribes(channel, announced.encoding == Encoding::kNone ? type : announced, KeysFor(channel),
                        demand.lossless);
  std::shared_ptr<JoinedInbound> joined;
  try {
    pairs_.OwnChanged(channel);
    joined = JoinInbound(channel, type, demand, sink);
  } catch (...) {
    EndSubscribing(channel);
    throw;
  }
  Announce();
  return joined;
}

std::shared_ptr<JoinedInbound> BridgeCore::JoinInbound(const std::string& channel, const TypeInfo& type,
                                                       const Demand& demand, InboundSink& sink) {
  auto joined = std::make_shared<JoinedInbound>(channel, type, demand, sink, transports_.size(),
                                                [this, channel](SessionId peer, TransportIndex from) {
                                                  options_.later({}, [this, channel, peer, from] {
                                                    peers_.Moved(peer, channel);
                                                    if (open_[from] != nullptr)
                                                      open_[from]->AskAgain();  // It drops the channel.
                                                  });
                                                });
  Join(inbound_, joined);
  return joined;
}

void BridgeCore::SetLossless(const std::string& channel, bool lossless) {
  if (announcer_.SetLossless(channel, lossless)) Announce();
}

void BridgeCore::EndSubscribing(const std::string& channel) {
  announcer_.EndSubscribing(channel);
  Announce();
}

void BridgeCore::EndPublishing(const std::string& channel) {
  announcer_.EndPublishing(channel);
  Announce();
}

void BridgeCore::Announce() {
  if (zmq() != nullptr) announcer_.SetEndpoints(zmq()->BoundEndpoints());
  announcer_.Announce();
  listener_.OnChannels();
}

void BridgeCore::AskAgain() noexcept {
  for (Transport* const transport : open_.All()) transport->AskAgain();
}

}  // namespace hgros
