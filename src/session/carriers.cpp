#include "session/carriers.hpp"

#include <algorithm>
#include <utility>

namespace hgros {
namespace {

constexpr auto kSharedMemoryPatience = std::chrono::seconds(2);

template <class Joined>
void AddTo(std::vector<std::weak_ptr<Joined>>& list, const std::shared_ptr<Joined>& joined) {
  std::erase_if(list, [](const auto& entry) { return entry.expired(); });
  list.push_back(joined);
}

}  // namespace

void Carriers::Ear::OnPeerCame(const PeerInfo& peer) noexcept { carriers_.peers_.Came(peer, kind_); }

void Carriers::Ear::OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept {
  if (carriers_.peers_.Gone(peer, kind_, reason)) {
    carriers_.AskAgain(kind_ == CarrierKind::kShm ? CarrierKind::kZmq : CarrierKind::kShm);
  }
  // It may come back that way, or never.
  if (kind_ == CarrierKind::kShm) carriers_.AwaitSharedMemory(peer.id, peer.process, peer.pid);
}

void Carriers::Ear::OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view what) noexcept {
  carriers_.listener_.OnTypeMismatch(channel, peer, what);
}

Carriers::Carriers(CarrierOptions options, TransportListener& listener, Log& log)
    : listener_(listener), log_(log), options_(std::move(options)), peers_(listener, log) {
  options_.zmq.takes = [this](SessionId peer) { return peers_.Take(peer, CarrierKind::kZmq); };
  own_ = AnnouncementOfThisProcess(options_.zmq.session, 0);
  own_.process = options_.zmq.process;
  if (options_.shm) {
    ShmOptions shm = *options_.shm;
    shm.takes = [this](SessionId peer) { return peers_.Take(peer, CarrierKind::kShm); };
    try {
      shm_ = MakeShmTransport(std::move(shm), shm_ear_, log);
      own_.shared_memory = shm_->place();
    } catch (const std::exception& error) {
      log.Write(LogLevel::kWarning,
                std::string("Sessions of this host are not reached through shared memory. ") + error.what());
    }
  }
  // Before endpoints are bound: who finds us there can find us in the registry as well.
  if (options_.registry) {
    try {
      registry_ = OpenRegistry(*options_.registry, *this, log);
      registry_->Announce(own_);
    } catch (const std::exception& error) {
      registry_.reset();
      log.Write(LogLevel::kWarning, std::string("Sessions of this host are not looked for. ") + error.what());
    }
  }
  if (!options_.zmq.publish.empty() || !options_.zmq.subscribe.empty()) Zmq();
}

Carriers::~Carriers() { Close(0); }

void Carriers::Close(int linger_ms) noexcept {
  std::unique_ptr<Discovery> registry;
  {
    const std::scoped_lock lock(announcing_);
    registry = std::move(registry_);
  }
  registry.reset();  // Nobody comes any more.
  if (shm_) shm_->Close(linger_ms);
  if (zmq_) zmq_->Close(linger_ms);
}

ZmqTransport& Carriers::Zmq() {
  if (zmq_) return *zmq_;
  zmq_ = MakeZmqTransport(options_.zmq, zmq_ear_, log_);
  for (const auto& entry : outbound_) {
    if (const auto joined = entry.lock()) joined->Add(*zmq_);
  }
  for (const auto& entry : inbound_) {
    if (const auto joined = entry.lock()) joined->Add(*zmq_);
  }
  Announce();
  return *zmq_;
}

std::shared_ptr<JoinedOutbound> Carriers::Advertise(const std::string& channel, const TypeInfo& type,
                                                    OutboundSource& source) {
  auto joined = std::make_shared<JoinedOutbound>(channel, type, source);
  if (shm_) joined->Add(*shm_);
  if (zmq_) joined->Add(*zmq_);
  AddTo(outbound_, joined);
  {
    const std::scoped_lock lock(announcing_);
    Own(channel, type).publishes = true;
  }
  Announce();
  return joined;
}

std::shared_ptr<JoinedInbound> Carriers::Subscribe(const std::string& channel, const TypeInfo& type,
                                                   const Demand& demand, InboundSink& sink) {
  auto joined = std::make_shared<JoinedInbound>(channel, type, demand, sink);
  if (shm_) joined->Add(*shm_);
  if (zmq_) joined->Add(*zmq_);
  AddTo(inbound_, joined);
  {
    const std::scoped_lock lock(announcing_);
    ChannelAnnouncement& entry = Own(channel, type);
    entry.subscribes = true;
    entry.lossless = demand.lossless;
  }
  Announce();
  return joined;
}

ChannelAnnouncement& Carriers::Own(const std::string& channel, const TypeInfo& type) {
  const auto known = std::ranges::find(own_.channels, channel, &ChannelAnnouncement::channel);
  ChannelAnnouncement& entry = known == own_.channels.end() ? own_.channels.emplace_back() : *known;
  entry.channel = channel;
  entry.type_name = type.name;
  entry.encoding = type.encoding;
  entry.fingerprint = type.fingerprint;
  return entry;
}

void Carriers::Unannounce(const std::string& channel) {
  {
    const std::scoped_lock lock(announcing_);
    const auto entry = std::ranges::find(own_.channels, channel, &ChannelAnnouncement::channel);
    if (entry == own_.channels.end()) return;
    entry->subscribes = false;
    if (!entry->publishes) own_.channels.erase(entry);
  }
  Announce();
}

void Carriers::Announce() {
  const std::scoped_lock lock(announcing_);
  if (!registry_) return;
  if (zmq_) own_.endpoints = zmq_->BoundEndpoints();
  try {
    registry_->Announce(own_);
  } catch (const std::exception& error) {
    log_.WriteLimited(LogLevel::kWarning, "announce",
                      std::string("Other sessions of this host do not see what has changed here. ") + error.what());
  }
}

// Of two sessions the one with the smaller id connects.
void Carriers::OnCame(const Announcement& peer) {
  if (!shm_ || peer.shared_memory.empty() || peer.boot_id != own_.boot_id) return;
  peers_.Expect(peer.session);
  AwaitSharedMemory(peer.session, peer.process, peer.pid);
  if (options_.zmq.session.value < peer.session.value) shm_->AddPeer(peer.shared_memory);
}

void Carriers::OnChanged(const Announcement& /*peer*/) {}

void Carriers::OnGone(const Announcement& last, std::string_view /*reason*/) {
  peers_.Unexpect(last.session);
  AskAgain(CarrierKind::kZmq);  // What is still reached otherwise is no longer left to shared memory.
  if (shm_ && !last.shared_memory.empty()) shm_->RemovePeer(last.shared_memory);
}

// It is on this host, and may still not be able to share memory with us, in a container for one.
void Carriers::AwaitSharedMemory(SessionId id, const std::string& process, std::int64_t pid) {
  options_.later(kSharedMemoryPatience, [this, id, process, pid] {
    const PeerCarriers::Without without = peers_.GiveUp(id);
    if (without == PeerCarriers::Without::kNotNeeded) return;
    const std::string who = "Session " + id.ToString() + " (" + process + ", process " + std::to_string(pid) +
                            ") was found on this host, but no memory can be shared with it";
    const std::string mend = " Check whether both run as one user and in one network namespace.";
    if (without == PeerCarriers::Without::kReached) {
      log_.Write(LogLevel::kWarning, who + ": ZeroMQ carries its messages." + mend);
    } else {
      log_.Write(LogLevel::kWarning, who + ", and no endpoint leads to it: nothing passes between the two." + mend);
    }
    AskAgain(CarrierKind::kZmq);
  });
}

void Carriers::AskAgain(CarrierKind kind) noexcept {
  if (kind == CarrierKind::kShm && shm_) shm_->AskAgain();
  if (kind == CarrierKind::kZmq && zmq_) zmq_->AskAgain();
}

TransportStats Carriers::stats() const {
  TransportStats sum;
  const auto add = [&sum](const TransportStats& stats) {
    for (std::size_t i = 0; i < sum.faults.size(); ++i) sum.faults[i] += stats.faults[i];
    sum.repeats += stats.repeats;
  };
  if (shm_) add(shm_->stats());
  if (zmq_) add(zmq_->stats());
  return sum;
}

}  // namespace hgros
