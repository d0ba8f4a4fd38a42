#include "bridge/lan_peers.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "hgros/base/system_limits.hpp"

namespace hgros {
namespace {

constexpr std::string_view kTcp = "tcp://";
// Least time between two rounds of Act(), so that thousands of endpoints do not keep a thread busy. In each round at
// most one try gives way: its descriptors are closed by another thread, a moment later. A refused try gives way after
// it.
constexpr auto kRound = std::chrono::milliseconds(15);
// Pause of an endpoint after its first failure while others wait. It doubles with each further failure.
constexpr auto kFirstPause = std::chrono::seconds(1);
constexpr unsigned kMaxDoublings = 5;
// A session that is heard and does not answer within this time is logged.
constexpr auto kReportAfter = std::chrono::seconds(3);
constexpr auto kReportPeriod = std::chrono::minutes(10);

// The address in "tcp://ADDRESS:PORT".
std::string HostOf(std::string_view endpoint) {
  endpoint.remove_prefix(std::min(kTcp.size(), endpoint.size()));
  return std::string(endpoint.substr(0, endpoint.rfind(':')));
}

std::chrono::steady_clock::duration Pause(unsigned failures) {
  if (failures == 0) return {};
  return kFirstPause * (1U << std::min(failures - 1, kMaxDoublings));
}

}  // namespace

LanPeers::LanPeers(ZmqTransport& zmq, Log& log, std::chrono::milliseconds patience, Later later,
                   std::set<std::string> configured)
    : zmq_(zmq),
      log_(log),
      patience_(patience),
      later_(std::move(later)),
      most_(std::min(DescriptorLimit() / kDescriptors, kMostEndpoints)),
      configured_(std::move(configured)) {}

void LanPeers::OnCame(const Announcement& peer) {
  const std::scoped_lock lock(mutex_);
  Update(peer, peer.endpoints);
}

void LanPeers::OnChanged(const Announcement& peer) { OnCame(peer); }

void LanPeers::OnGone(const Announcement& last, std::string_view /*reason*/) {
  const std::scoped_lock lock(mutex_);
  Update(last, {});
}

void LanPeers::Configure(const std::string& endpoint) {
  const std::scoped_lock lock(mutex_);
  const auto entry = heard_.find(endpoint);
  if (!configured_.insert(endpoint).second || entry == heard_.end()) return;
  const Time now = std::chrono::steady_clock::now();
  Disconnect(*entry, now);
  FillTries(now);
}

void LanPeers::Release(const std::string& endpoint) {
  const std::scoped_lock lock(mutex_);
  if (configured_.erase(endpoint) > 0) ActAt(std::chrono::steady_clock::now());
}

void LanPeers::Update(const Announcement& peer, std::vector<std::string> endpoints) {
  for (const std::string& endpoint : announced_[peer.session]) heard_[endpoint].sessions.erase(peer.session);
  for (std::size_t i = 0; i < endpoints.size(); ++i) {
    const std::string& endpoint = endpoints[i];
    Endpoint& entry = heard_[endpoint];
    if (entry.sessions.empty()) entry.sender = i < peer.senders.size() ? peer.senders[i] : peer.sender;
    entry.sessions.insert(peer.session);
    entry.host = HostOf(endpoint);
  }
  if (endpoints.empty()) {
    announced_.erase(peer.session);
  } else {
    announced_[peer.session] = std::move(endpoints);
  }
  const Time now = std::chrono::steady_clock::now();
  FillTries(now);
  ActAt(now);
}

void LanPeers::SetState(Endpoint& endpoint, State state, Time now) {
  tries_ += (state == State::kTried ? 1 : 0) - (endpoint.state == State::kTried ? 1 : 0);
  if (endpoint.state == State::kWaiting && state != State::kWaiting) {
    ++connected_;
    ++connected_at_[endpoint.host];
  } else if (endpoint.state != State::kWaiting && state == State::kWaiting) {
    --connected_;
    if (--connected_at_[endpoint.host] == 0) connected_at_.erase(endpoint.host);
  }
  endpoint.state = state;
  endpoint.since = now;
}

void LanPeers::FillTries(Time now) {
  while (tries_ < kMaxTries) {
    auto* const next = FindNext(now);
    if (next == nullptr) return;
    Connect(*next, now);
  }
}

void LanPeers::Connect(Endpoints::value_type& entry, Time now) {
  const std::string& endpoint = entry.first;
  Endpoint& state = entry.second;
  SetState(state, State::kTried, now);
  state.tried = now;
  state.number = ++last_number_;
  state.refused = false;
  SubscribeEndpoint added{endpoint, std::nullopt, {}};
  added.on_event = [this, endpoint, number = state.number](EndpointEvent event, SessionId session) {
    OnEvent(endpoint, number, event, session);
  };
  try {
    zmq_.AddSubscribeEndpoint(added);
  } catch (const std::exception& error) {
    SetState(state, State::kWaiting, now);
    ++state.failures;
    log_.WriteLimited(LogLevel::kWarning, "lan connect",
                      std::string("No connection to a session that the beacon hears. ") + error.what());
  }
}

void LanPeers::Disconnect(Endpoints::value_type& entry, Time now) {
  auto& [endpoint, state] = entry;
  if (state.state != State::kWaiting) zmq_.RemoveSubscribeEndpoint(endpoint);
  SetState(state, State::kWaiting, now);
  state.number = 0;
}

void LanPeers::OnEvent(const std::string& endpoint, std::uint64_t number, EndpointEvent event, SessionId session) {
  const std::scoped_lock lock(mutex_);
  const auto found = heard_.find(endpoint);
  if (found == heard_.end() || found->second.number != number) return;
  Endpoint& entry = found->second;
  if (event == EndpointEvent::kFailed && (entry.state != State::kTried || std::exchange(entry.refused, true))) return;
  const Time now = std::chrono::steady_clock::now();
  if (event == EndpointEvent::kReached) {
    SetState(entry, State::kReached, now);
    entry.answered = session;
    entry.failures = 0;
    entry.reported = false;
    FillTries(now);
  } else if (event == EndpointEvent::kLost) {
    SetState(entry, State::kLost, now);
  }
  ActAt(now);
}

void LanPeers::ActAt(Time when) {
  when = std::max(when, acted_ + kRound);
  if (due_ && *due_ <= when) return;
  due_ = when;
  later_(when - std::chrono::steady_clock::now(), [this, when] { Act(when); });
}

void LanPeers::Act(Time due) {
  const std::scoped_lock lock(mutex_);
  if (due_ != due) return;  // Another errand was posted for an earlier time.
  due_.reset();
  const Time now = acted_ = std::chrono::steady_clock::now();
  EndLost(now);
  for (auto& entry : heard_) {
    const bool late = entry.second.state == State::kTried && now - entry.second.since >= kReportAfter;
    if (late) ReportUnanswered(entry);
  }
  FillTries(now);
  auto* const next = FindNext(now);
  if (next != nullptr && tries_ >= kMaxTries) {
    Endpoints::value_type& oldest = FindOldestTry();
    if (EndOf(oldest.second) <= now) {
      ReportUnanswered(oldest);
      ++oldest.second.failures;
      Disconnect(oldest, now);
      Connect(*next, now);
    }
  }
  if (const auto when = NextAct(now)) ActAt(*when);
}

// Ends what is not heard any more, and lets a session that does not come back wait like a new one.
void LanPeers::EndLost(Time now) {
  for (auto entry = heard_.begin(); entry != heard_.end();) {
    Endpoint& state = entry->second;
    const bool unheard = state.sessions.empty();
    const bool lost = state.state == State::kLost && now - state.since >= patience_;
    if (lost || (unheard && state.state == State::kTried)) Disconnect(*entry, now);
    entry = unheard && state.state == State::kWaiting ? heard_.erase(entry) : std::next(entry);
  }
}

void LanPeers::ReportUnanswered(Endpoints::value_type& entry) {
  if (IsReachedElsewhere(entry) || std::exchange(entry.second.reported, true)) return;
  if (unanswered_.empty()) unanswered_ = entry.first;
  log_.WriteLimited(LogLevel::kWarning, "lan unanswered",
                    "The beacon hears sessions that do not answer, the first one at " + unanswered_ +
                        ": does a firewall of either host stop that port, are the keys (`network.security`) right, "
                        "and do both run the same version?",
                    kReportPeriod);
}

void LanPeers::ReportFull(const std::string& host) {
  if (full_.empty()) full_ = host;
  log_.WriteLimited(LogLevel::kWarning, "lan full",
                    "The beacon hears more sessions at one address, the first one " + full_ +
                        ", than may be connected to there: those of an address get a quarter of the open files that "
                        "others leave. If they are yours, raise the limit (ulimit -n, LimitNOFILE=).",
                    kReportPeriod);
}

std::size_t LanPeers::ConnectedAt(const std::string& host) const {
  const auto found = connected_at_.find(host);
  return found == connected_at_.end() ? 0 : found->second;
}

std::size_t LanPeers::ShareOf(const std::string& host) const {
  const std::size_t elsewhere = std::min(connected_ - ConnectedAt(host), most_);
  return std::max<std::size_t>((most_ - elsewhere) / kShare, 1);
}

bool LanPeers::Waits(const Endpoints::value_type& entry) const {
  return entry.second.state == State::kWaiting && !entry.second.sessions.empty() &&
         !configured_.contains(entry.first) && !IsReachedElsewhere(entry);
}

// A host with several addresses is connected to at one of them.
bool LanPeers::IsReachedElsewhere(const Endpoints::value_type& entry) const {
  return std::ranges::all_of(entry.second.sessions, [&](SessionId session) {
    const auto announced = announced_.find(session);
    return announced != announced_.end() && std::ranges::any_of(announced->second, [&](const std::string& endpoint) {
             const auto other = heard_.find(endpoint);
             return other != heard_.end() && &*other != &entry && other->second.state == State::kReached &&
                    other->second.answered == session && other->second.sender != entry.second.sender;
           });
  });
}

LanPeers::Endpoints::value_type* LanPeers::FindNext(Time now) {
  std::map<std::string_view, Time> served;  // By sender.
  for (const auto& [endpoint, state] : heard_) {
    Time& latest = served.try_emplace(state.sender, state.tried).first->second;
    latest = std::max(latest, state.tried);
  }
  Endpoints::value_type* next = nullptr;
  using Rank = std::tuple<Time, unsigned, bool, Time>;
  Rank best;
  const std::string* full = nullptr;
  for (auto& entry : heard_) {
    const auto& [endpoint, state] = entry;
    if (!Waits(entry) || now - state.since < Pause(state.failures)) continue;
    if (IsFull(state.host)) {
      full = &state.host;
      continue;
    }
    // An endpoint at the sender's own address is more likely to be its own.
    const bool elsewhere = !endpoint.starts_with(std::string(kTcp) + state.sender + ":");
    const Rank rank(served[state.sender], state.failures, elsewhere, state.since);
    if (next != nullptr && best <= rank) continue;
    next = &entry;
    best = rank;
  }
  if (full != nullptr) ReportFull(*full);
  return next;
}

LanPeers::Time LanPeers::EndOf(const Endpoint& tried) { return tried.since + (tried.refused ? kRound : kTryTime); }

LanPeers::Endpoints::value_type& LanPeers::FindOldestTry() {
  Endpoints::value_type* oldest = nullptr;
  for (auto& entry : heard_) {
    if (entry.second.state != State::kTried) continue;
    if (oldest == nullptr || EndOf(entry.second) < EndOf(oldest->second)) oldest = &entry;
  }
  return *oldest;
}

std::optional<LanPeers::Time> LanPeers::NextAct(Time now) {
  std::optional<Time> first;
  const auto consider = [&](Time when) { first = first ? std::min(*first, when) : when; };
  std::optional<Time> next_try;
  for (const auto& entry : heard_) {
    const Endpoint& state = entry.second;
    if (state.state == State::kLost) consider(state.since + patience_);
    if (state.state == State::kTried && !state.reported) consider(state.since + kReportAfter);
    if (!Waits(entry) || IsFull(state.host)) continue;
    const Time when = state.since + Pause(state.failures);
    next_try = next_try ? std::min(*next_try, when) : when;
  }
  if (next_try) {
    Time free = now;
    if (tries_ >= kMaxTries) free = EndOf(FindOldestTry().second);
    consider(std::max(*next_try, free));
  }
  return first;
}

bool ReachesOtherHosts(std::string_view endpoint) noexcept {
  if (!endpoint.starts_with(kTcp)) return false;
  const std::string_view host = endpoint.substr(kTcp.size());
  return !host.starts_with("127.") && !host.starts_with("localhost:") && !host.starts_with('[');  // A beacon uses IPv4.
}

}  // namespace hgros
