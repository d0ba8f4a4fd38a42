#include "transport/zmq/zmq_core.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "hgros/base/error.hpp"
#include "transport/leavings.hpp"
#include "transport/zmq/control.hpp"
#include "transport/zmq/endpoint.hpp"

namespace hgros::zmq {
namespace {

constexpr int kGoodbyeMs = 50;

template <typename Endpoint>
auto Find(std::vector<std::shared_ptr<Endpoint>>& list, const std::string& endpoint) {
  const std::string full = FullEndpoint(endpoint);
  return std::ranges::find_if(list, [&](const auto& entry) { return entry->endpoint() == full; });
}

template <typename Endpoint>
Endpoint& Require(std::vector<std::shared_ptr<Endpoint>>& list, const std::string& endpoint) {
  const auto found = Find(list, endpoint);
  if (found == list.end()) {
    throw Error("There is no endpoint " + endpoint + " here.", {}, "Use an endpoint that was configured or added.");
  }
  return **found;
}

template <typename Core>
void AddNew(std::map<std::string, std::shared_ptr<Core>>& cores, const std::shared_ptr<Core>& core,
            std::string_view what) {
  if (cores.emplace(core->name, core).second) return;
  throw Error("Channel " + core->name + " is " + std::string(what) + " here already.", {},
              "Share the first object, or destroy it first.");
}

template <typename Core>
void Remove(std::map<std::string, std::shared_ptr<Core>>& cores, const std::shared_ptr<Core>& core) {
  const auto found = cores.find(core->name);
  if (found != cores.end() && found->second == core) cores.erase(found);
}

void CallAll(Actions& actions) {
  for (auto& action : actions) action();
  actions.clear();
}

}  // namespace

ZmqCore::ZmqCore(ZmqOptions options, TransportListener& listener, Log& log)
    : shared_(std::move(options), listener, log),
      next_tick_(std::chrono::steady_clock::now() + shared_.options.heartbeat),
      deadline_(next_tick_) {
  poller_.Add(shared_.waker->fd(), woken_);
  if (const auto& security = shared_.options.security) {
    desk_ = std::make_unique<AdmissionDesk>(shared_.context, *security, log);
    poller_.Add(desk_->fd(), desk_input_);
  }
  for (const auto& endpoint : shared_.options.publish) AddPublisher(endpoint);
  for (const auto& endpoint : shared_.options.subscribe) AddSubscriber(endpoint);
}

ZmqCore::~ZmqCore() { Close(0, 0); }

void ZmqCore::Start() { pool_.Start(); }

void ZmqCore::Wake() noexcept { shared_.waker->Wake(); }

void ZmqCore::Close(int linger_ms, int at_most_ms) noexcept {
  if (shared_.closing.exchange(true)) return;
  const auto began = std::chrono::steady_clock::now();
  if (linger_ms > 0) {
    arrival_.Await(std::chrono::milliseconds(linger_ms), std::chrono::milliseconds(at_most_ms),
                   [this] { return LookAtArriving(); });
  }
  // The goodbye is for those that still read, too, if others have used up the time.
  const auto waited = std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - began);
  linger_ms = std::max(linger_ms - static_cast<int>(waited.count()), std::min(linger_ms, kGoodbyeMs));
  pool_.Stop();
  Actions unheard;  // Destroyed after the lock, because messages may be destroyed with it.
  std::unique_lock lock(mutex_);
  closed_ = true;
  for (const auto& endpoint : subscribers_) endpoint->Close(linger_ms, false, unheard);
  for (const auto& endpoint : publishers_) endpoint->Close(linger_ms, unheard);
  if (desk_) desk_->Close();
  lock.unlock();
  shared_.SayUnconfirmed();
}

Arriving ZmqCore::LookAtArriving() {
  Arriving arriving;
  const std::shared_lock lock(mutex_);
  for (const auto& endpoint : publishers_) endpoint->LookAtArriving(arriving);
  return arriving;
}

void ZmqCore::AddPublisher(const PublishEndpoint& endpoint) {
  const std::unique_lock lock(mutex_);
  if (closed_) return;
  if (Find(publishers_, endpoint.endpoint) != publishers_.end()) {
    throw Error("This session publishes at " + endpoint.endpoint + " already.", {}, "Name it once, with all channels.");
  }
  auto added = std::make_shared<PublisherEndpoint>(shared_, endpoint,
                                                   [this](InboundMessage&& order) { TakeOrder(std::move(order)); });
  for (const auto& [name, core] : outbound_) added->Offer(core);
  poller_.Add(added->fd(), added->input());
  poller_.Add(added->watch().fd(), added->watch().input());
  poller_.Add(added->watch().unfinished().fd(), added->watch().unfinished().input());
  publishers_.push_back(std::move(added));
  ++version_;
  Wake();
}

void ZmqCore::AddSubscriber(const SubscribeEndpoint& endpoint) {
  const std::unique_lock lock(mutex_);
  if (closed_) return;
  if (Find(subscribers_, endpoint.endpoint) != subscribers_.end()) {
    throw Error("This session subscribes at " + endpoint.endpoint + " already.", {},
                "Name it once, with all channels.");
  }
  auto added = std::make_shared<SubscriberEndpoint>(
      shared_, poller_, endpoint, [this](const InboundCore* core) { AskAgain(core); },
      [this](SessionId session) { OnReplaced(session); });
  for (const auto& [name, core] : inbound_) added->Subscribe(core);
  poller_.Add(added->fd(), added->input());
  poller_.Add(added->monitor_fd(), added->monitor_input());
  subscribers_.push_back(std::move(added));
  ++version_;
  Wake();
}

bool ZmqCore::RemovePublisher(const std::string& endpoint) {
  const std::unique_lock lock(mutex_);
  const auto found = Find(publishers_, endpoint);
  if (found == publishers_.end()) return false;
  Actions actions;
  for (const auto& [name, core] : outbound_) (*found)->Withdraw(core, actions);
  (*found)->Close(static_cast<int>(shared_.options.linger.count()), actions);
  shared_.PostActions(std::move(actions));
  old_publishers_.push_back(std::move(*found));
  publishers_.erase(found);
  ++version_;
  Wake();
  return true;
}

bool ZmqCore::RemoveSubscriber(const std::string& endpoint) {
  {
    const std::unique_lock lock(mutex_);
    const auto found = Find(subscribers_, endpoint);
    if (found == subscribers_.end()) return false;
    const bool others = std::ranges::any_of(
        subscribers_, [&](const auto& other) { return SubscriberEndpoint::LeadAlike(**found, *other); });
    Actions actions;
    (*found)->Close(static_cast<int>(shared_.options.linger.count()), others, actions);
    (*found)->SetLastActions(std::move(actions));
    old_subscribers_.push_back(std::move(*found));
    subscribers_.erase(found);
    ++version_;
  }
  Wake();
  return true;
}

void ZmqCore::SetPublishChannels(const std::string& endpoint, const ChannelList& channels) {
  const std::unique_lock lock(mutex_);
  Require(publishers_, endpoint).SetChannels(channels);
}

void ZmqCore::SetSubscribeChannels(const std::string& endpoint, const ChannelList& channels) {
  const std::unique_lock lock(mutex_);
  Require(subscribers_, endpoint).SetChannels(channels);
}

std::vector<std::string> ZmqCore::BoundEndpoints() const {
  const std::shared_lock lock(mutex_);
  std::vector<std::string> bound;
  for (const auto& endpoint : publishers_) bound.push_back(endpoint->bound());
  return bound;
}

std::vector<SessionChannels> ZmqCore::KnownChannels() const {
  const std::shared_lock lock(mutex_);
  std::vector<SessionChannels> known;
  for (const auto& endpoint : subscribers_) endpoint->AddOffers(known);
  for (const auto& endpoint : publishers_) endpoint->AddWishes(known);
  return known;
}

void ZmqCore::Offer(const std::shared_ptr<OutboundCore>& core) {
  const std::unique_lock lock(mutex_);
  AddNew(outbound_, core, "advertised");
  for (const auto& endpoint : publishers_) endpoint->Offer(core);
}

void ZmqCore::Withdraw(const std::shared_ptr<OutboundCore>& core) {
  Actions unheard;
  {
    const std::unique_lock lock(mutex_);
    Remove(outbound_, core);
    for (const auto& endpoint : publishers_) endpoint->Withdraw(core, unheard);
  }
  core->gate.Close();
}

void ZmqCore::Want(const std::shared_ptr<InboundCore>& core) {
  const std::unique_lock lock(mutex_);
  AddNew(inbound_, core, "subscribed to");
  for (const auto& endpoint : subscribers_) endpoint->Subscribe(core);
}

void ZmqCore::Unwant(const std::shared_ptr<InboundCore>& core) {
  const std::unique_lock lock(mutex_);
  Remove(inbound_, core);
  for (const auto& endpoint : subscribers_) endpoint->Unsubscribe(core);
}

void ZmqCore::ChangeDemand(const std::shared_ptr<InboundCore>& core) {
  const std::shared_lock lock(mutex_);
  for (const auto& endpoint : subscribers_) endpoint->UpdateDemand(core);
}

void ZmqCore::AskAgain(const InboundCore* core) {
  const std::shared_lock lock(mutex_);
  for (const auto& endpoint : subscribers_) endpoint->AskAgain(core);
}

void ZmqCore::OnReplaced(SessionId session) {
  Actions actions;
  {
    const std::shared_lock lock(mutex_);
    for (const auto& endpoint : publishers_) endpoint->OnReplaced(session, actions);
  }
  shared_.PostActions(std::move(actions));
}

OrderWay ZmqCore::SendOrder(SessionId publisher, std::string_view request) {
  const std::shared_lock lock(mutex_);
  OrderWay best = OrderWay::kNone;
  for (const auto& endpoint : subscribers_) {
    if (best != OrderWay::kSent) best = std::max(best, endpoint->SendOrder(publisher, request));
  }
  return best;
}

void ZmqCore::TakeOrder(InboundMessage&& order) {
  std::shared_ptr<InboundCore> core;
  {
    const std::shared_lock lock(mutex_);
    const auto found = inbound_.find(std::string(kOrdersChannel));
    if (found == inbound_.end()) return;
    core = found->second;
  }
  // The library's own subscriber of that channel asks for no run.
  (void)InboundCore::Deliver(core, std::move(order), shared_.repeats);
}

PublishStatus ZmqCore::Reserve(OutboundCore& core) {
  if (shared_.closing.load(std::memory_order_relaxed)) return PublishStatus::kClosed;
  if (core.lossless.load() == 0) return PublishStatus::kOk;
  const std::shared_lock lock(mutex_);
  std::vector<std::unique_lock<std::mutex>> locks;
  locks.reserve(publishers_.size());
  for (const auto& endpoint : publishers_) locks.emplace_back(endpoint->mutex());
  const bool room =
      std::ranges::all_of(publishers_, [&](const auto& endpoint) { return endpoint->HasRoomLocked(core); });
  if (!room) {
    core.refused = true;
    return PublishStatus::kFull;
  }
  for (const auto& endpoint : publishers_) endpoint->ReserveLocked(core);
  return PublishStatus::kOk;
}

void ZmqCore::Cancel(const std::shared_ptr<OutboundCore>& core) {
  if (core->lossless.load() == 0) return;
  const std::shared_lock lock(mutex_);
  for (const auto& endpoint : publishers_) endpoint->CancelReservation(core);
}

std::size_t ZmqCore::Unfinished(const OutboundCore& core) const {
  const std::shared_lock lock(mutex_);
  std::size_t unfinished = 0;
  for (const auto& endpoint : publishers_) unfinished += endpoint->Unfinished(core);
  return unfinished;
}

void ZmqCore::Commit(const std::shared_ptr<OutboundCore>& core, const PacketHead& head, const Payload& data) {
  if (shared_.closing.load(std::memory_order_relaxed) || core->subscribers.load(std::memory_order_relaxed) == 0) {
    return;
  }
  core->NoteCommit(shared_.log, head.id.sequence);
  const auto message = std::make_shared<const WireMessage>(head, data);
  Leavings leavings;
  const std::shared_lock lock(mutex_);
  for (const auto& endpoint : publishers_) endpoint->Commit(core, message, leavings.messages);
}

void ZmqCore::UpdateWatch() {
  if (watch_.version == version_.load()) return;
  const std::unique_lock lock(mutex_);
  watch_.version = version_.load();
  watch_.publishers = publishers_;
  watch_.subscribers = subscribers_;
  std::ranges::move(old_subscribers_, std::back_inserter(watch_.removed));
  old_subscribers_.clear();
}

void ZmqCore::Wait() noexcept {
  const auto left = deadline_.load(std::memory_order_relaxed) - std::chrono::steady_clock::now();
  const auto left_ms = std::chrono::ceil<std::chrono::milliseconds>(left).count();
  poller_.Wait(static_cast<int>(std::clamp<std::int64_t>(left_ms, 0, 60'000)));
}

LeaderPool::Task ZmqCore::Lead() noexcept {
  for (;;) {
    UpdateWatch();
    const auto now = std::chrono::steady_clock::now();
    if (now >= next_tick_) Tick(now);
    if (now >= next_look_) Look(now);
    if (desk_ && desk_input_.exchange(false)) desk_->Serve();

    Actions actions = shared_.CollectPosted();
    bool busy = !actions.empty();
    CallAll(actions);
    for (const auto& endpoint : watch_.publishers) {
      busy = endpoint->Serve(actions) || busy;
      busy = !actions.empty() || busy;
      CallAll(actions);
    }
    for (const auto* endpoints : {&watch_.removed, &watch_.subscribers}) {
      for (const auto& endpoint : *endpoints) {
        auto task = endpoint->Serve(busy);
        if (const auto next = endpoint->NextLook()) next_look_ = std::min(next_look_, *next);
        endpoint->SendCredit(false);
        if (!task) continue;
        if (Pending()) Wake();
        return task;
      }
    }
    if (!watch_.removed.empty()) {
      std::erase_if(watch_.removed, [](const auto& endpoint) { return !endpoint->pending(); });
    }
    if (shared_.closing.load()) {
      arrival_.NoteRound();
      // The pool may be waiting for its threads to end.
      if (busy) Wake();
      busy = false;
    }
    if (!busy) {
      SetDeadline();
      return {};
    }
  }
}

bool ZmqCore::Pending() const {
  const auto pending = [](const auto& endpoint) { return endpoint->pending(); };
  return std::ranges::any_of(watch_.subscribers, pending) || std::ranges::any_of(watch_.removed, pending) ||
         std::ranges::any_of(watch_.publishers, pending);
}

void ZmqCore::Tick(SteadyTime now) {
  const auto period = shared_.options.heartbeat;
  const bool overslept = now - next_tick_ > period;
  Actions actions;
  for (const auto& endpoint : watch_.publishers) {
    if (overslept) endpoint->ForgiveSilence(now);
    endpoint->Tick(now, actions);
    CallAll(actions);
  }
  for (const auto& endpoint : watch_.subscribers) {
    if (overslept) endpoint->ForgiveSilence(now);
    endpoint->Tick(now);
  }
  next_tick_ = std::min(now + period, shared_.silence.Report(now));
}

void ZmqCore::Look(SteadyTime now) {
  for (const auto& endpoint : watch_.subscribers) {
    if (const auto next = endpoint->NextLook(); next && *next <= now) endpoint->Look(now);
  }
}

void ZmqCore::SetDeadline() {
  next_look_ = SteadyTime::max();
  for (const auto& endpoint : watch_.subscribers) {
    if (const auto deadline = endpoint->Deadline(); deadline && *deadline < next_tick_) next_tick_ = *deadline;
    if (const auto next = endpoint->NextLook()) next_look_ = std::min(next_look_, *next);
  }
  deadline_.store(std::min(next_tick_, next_look_), std::memory_order_relaxed);
}

}  // namespace hgros::zmq
