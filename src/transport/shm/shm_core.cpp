#include "transport/shm/shm_core.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "hgros/base/error.hpp"

namespace hgros::shm {
namespace {

// Who has not greeted yet says no more than that at once.
constexpr std::size_t kMaxHelloBytes = 64 * 1024;
constexpr int kFramesAtOnce = 256;  // Of one peer before others have their turn.
constexpr auto kFirstPause = std::chrono::milliseconds(100);
constexpr auto kLongestPause = std::chrono::milliseconds(1000);
// epoll's marks of what is no pair.
constexpr std::uint64_t kListening = 1ULL << 32;
constexpr std::uint64_t kWoken = 1ULL << 33;
// With a pair's number: its process.
constexpr std::uint64_t kProcess = 1ULL << 34;

ShmOptions Completed(ShmOptions options) {
  if (options.session.value == 0) options.session = SessionId::Random();
  if (options.place.empty()) options.place = "hgros-" + options.session.ToString();
  return options;
}

template <class Cores>
void RequireNew(const Cores& cores, const std::string& channel, std::string_view what) {
  if (!cores.contains(channel)) return;
  throw Error("Channel " + channel + " is " + std::string(what) + " here already.", {},
              "Share the first object, or destroy it before.");
}

}  // namespace

ShmCore::ShmCore(ShmOptions options, TransportListener& listener, Log& log)
    : options_(Completed(std::move(options))),
      self_(OwnFacts(options_.session, options_.process)),
      listener_(listener),
      log_(log),
      registry_(listener),
      bell_(Patience{.busy = options_.wait == ShmWait::kBusy,
                     .spin = options_.wait == ShmWait::kSpin ? options_.spin : std::chrono::microseconds(0)}),
      pool_(std::make_shared<BlockPool>(options_.limit_bytes)),
      epoll_(epoll_create1(EPOLL_CLOEXEC)),
      next_tick_(std::chrono::steady_clock::now() + options_.heartbeat) {
  if (!epoll_.valid()) {
    throw Error(std::string("Cannot create an epoll descriptor: ") + std::strerror(errno) + ".", {},
                "Raise the limit of open files (ulimit -n).");
  }
  std::string fault;
  listening_ = ListenAt(options_.place, fault);
  if (!listening_.valid()) {
    throw Error("Other sessions of this host cannot be reached through shared memory: " + fault + ".", {},
                "Choose another place, or none to have one chosen.");
  }
  if (!Watch(listening_.fd(), kListening, EPOLLIN) || !Watch(waker_.fd(), kWoken, EPOLLIN)) {
    throw Error(std::string("Cannot wait for a descriptor: ") + std::strerror(errno) + ".");
  }
  for (const std::string& place : options_.peers) destinations_.emplace_back().place = place;
}

ShmCore::~ShmCore() { Close(0); }

bool ShmCore::Watch(int fd, std::uint64_t mark, std::uint32_t events) noexcept {
  epoll_event event{};
  event.events = events;
  event.data.u64 = mark;
  return epoll_ctl(epoll_.fd(), EPOLL_CTL_ADD, fd, &event) == 0;
}

void ShmCore::Start() {
  pool_of_readers_.Start();
  minder_ = std::jthread([this](const std::stop_token& stop) { Mind(stop); });
}

void ShmCore::Close(int linger_ms) noexcept {
  if (closing_.exchange(true)) return;
  WaitUntilSent(linger_ms);
  minder_.request_stop();
  waker_.Wake();
  if (minder_.joinable()) minder_.join();
  pool_of_readers_.Stop();
  pool_->Close();          // Peers may read on what is let go of below.
  Actions nobody_listens;  // Ends after the lock: messages may end with it.
  std::map<std::uint32_t, std::shared_ptr<Pair>> pairs;
  {
    const std::scoped_lock lock(mutex_);
    closed_ = true;
    {
      const std::scoped_lock pairs_lock(pairs_mutex_);
      pairs.swap(pairs_);
    }
    wire::PairMessage bye;
    bye.mutable_bye()->set_reason("the session ends");
    for (const auto& [number, pair] : pairs) {
      if (pair->alive.exchange(false)) pair->socket.Send(bye);
      for (auto& [name, wish] : pair->wishes) RemoveLink(wish, true, nobody_listens);
      pair->wishes.clear();
    }
  }
  for (const auto& [number, pair] : pairs) {
    if (std::exchange(pair->came, false)) registry_.Gone(pair->facts.info, "the session ends");
  }
  listening_ = {};
}

void ShmCore::WaitUntilSent(int linger_ms) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(linger_ms);
  const auto all_sent = [this] {
    const std::scoped_lock lock(mutex_);
    return std::ranges::all_of(Pairs(), [](const auto& pair) {
      return !pair->alive || (pair->waiting_bytes == 0 && pair->socket.all_sent() &&
                              std::ranges::all_of(pair->wishes, [](const auto& entry) {
                                return !entry.second.link || entry.second.link->flow.waiting() == 0;
                              }));
    });
  };
  std::unique_lock lock(sent_mutex_);
  while (!all_sent()) {
    // Whatever lets messages go counts a round.
    const auto seen = rounds_;
    if (!sent_.wait_until(lock, deadline, [&] { return rounds_ != seen; })) return;
  }
}

void ShmCore::CountRound() {
  if (!closing_.load()) return;
  const std::scoped_lock lock(sent_mutex_);
  ++rounds_;
  sent_.notify_all();
}

void ShmCore::Post(std::function<void()> action) {
  {
    const std::scoped_lock lock(posted_mutex_);
    posted_.push_back(std::move(action));
  }
  waker_.Wake();
}

void ShmCore::PostFor(Pair& pair, std::function<void(const std::shared_ptr<Pair>&)> action) {
  Post([pair = pair.weak_from_this(), action = std::move(action)] {
    if (const auto still = pair.lock()) action(still);
  });
}

void ShmCore::Post(Actions&& actions) {
  if (actions.empty()) return;
  {
    const std::scoped_lock lock(posted_mutex_);
    for (auto& action : actions) posted_.push_back(std::move(action));
  }
  actions.clear();
  waker_.Wake();
}

std::vector<std::shared_ptr<Pair>> ShmCore::Pairs() const {
  const std::scoped_lock lock(pairs_mutex_);
  std::vector<std::shared_ptr<Pair>> list;
  list.reserve(pairs_.size());
  for (const auto& [number, pair] : pairs_) list.push_back(pair);
  return list;
}

std::shared_ptr<Pair> ShmCore::PairAt(std::uint32_t number) const {
  const std::scoped_lock lock(pairs_mutex_);
  const auto found = pairs_.find(number);
  return found == pairs_.end() ? nullptr : found->second;
}

void ShmCore::AddPeer(const std::string& place) {
  {
    const std::scoped_lock lock(mutex_);
    if (closed_ || place == options_.place) return;
    if (std::ranges::any_of(destinations_, [&](const auto& known) { return known.place == place; })) return;
    destinations_.emplace_back().place = place;
  }
  waker_.Wake();
}

void ShmCore::RemovePeer(const std::string& place) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(destinations_, [&](const auto& known) { return known.place == place; });
}

void ShmCore::AskAgain() {
  const std::scoped_lock lock(mutex_);
  for (const auto& pair : Pairs()) {
    if (pair->alive) AskForAll(*pair);
  }
}

void ShmCore::Offer(const std::shared_ptr<OutboundCore>& core) {
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    RequireNew(channels_, core->name, "advertised");
    channels_[core->name].core = core;
    if (closed_) return;
    for (const auto& pair : Pairs()) {
      const auto wish = pair->wishes.find(core->name);
      if (pair->alive && wish != pair->wishes.end() && !wish->second.link) Activate(*pair, wish->second, actions);
    }
  }
  Post(std::move(actions));
}

void ShmCore::Withdraw(const std::shared_ptr<OutboundCore>& core) {
  Actions nobody_listens;
  {
    const std::scoped_lock lock(mutex_);
    const auto found = channels_.find(core->name);
    if (found != channels_.end() && found->second.core == core) {
      while (!found->second.links.empty()) {
        OutLink& link = *found->second.links.back();
        Pair& pair = link.pair;
        wire::PairMessage said;
        said.mutable_ended()->set_link(link.link);
        said.mutable_ended()->set_messages(link.flow.sent());
        pair.socket.Send(said);
        RemoveLink(pair.wishes.at(core->name), true, nobody_listens);
        pair.ended[core->name] = pair.wishes.at(core->name).asked.link();
        pair.wishes.erase(core->name);  // It asks again.
      }
      channels_.erase(found);
    }
  }
  core->gate.Close();
}

void ShmCore::Want(const std::shared_ptr<InboundCore>& core) {
  const std::scoped_lock lock(mutex_);
  RequireNew(inbound_, core->name, "subscribed to");
  inbound_.emplace(core->name, core);
  if (closed_) return;
  for (const auto& pair : Pairs()) {
    if (pair->asks) Ask(*pair, core);
  }
}

void ShmCore::Unwant(const std::shared_ptr<InboundCore>& core) {
  Actions nobody_listens;
  {
    const std::scoped_lock lock(mutex_);
    const auto found = inbound_.find(core->name);
    if (found != inbound_.end() && found->second == core) {
      inbound_.erase(found);
      for (const auto& pair : Pairs()) ForgetWish(*pair, core->name, {}, nobody_listens);
    }
  }
  core->Close();
}

void ShmCore::ChangeDemand(const std::shared_ptr<InboundCore>& core) {
  const std::scoped_lock lock(mutex_);
  for (const auto& pair : Pairs()) {
    const std::scoped_lock in_lock(pair->in_mutex);
    const auto link = pair->in_channels.find(core->name);
    if (link != pair->in_channels.end()) SayWish(*pair, *pair->in_links.at(link->second));
  }
}

ShmUsage ShmCore::usage() const {
  const auto usage = pool_->usage();
  return {.segment_bytes = usage.segment_bytes,
          .segments = usage.segments,
          .blocks_in_use = usage.blocks_in_use,
          .sent_apart = sent_apart_.load(std::memory_order_relaxed)};
}

TransportStats ShmCore::stats() const {
  TransportStats stats;
  for (std::size_t i = 0; i < stats.faults.size(); ++i) stats.faults[i] = faults_[i].load();
  stats.repeats = repeats_.load();
  return stats;
}

SteadyTime ShmCore::NextDeadline() const {
  SteadyTime next = next_tick_;
  const std::scoped_lock lock(mutex_);
  for (const Destination& destination : destinations_) {
    if (!destination.Connected()) next = std::min(next, destination.next_try);
  }
  return next;
}

void ShmCore::Mind(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const auto now = std::chrono::steady_clock::now();
    TryDestinations(now);
    if (now >= next_tick_) Tick(now);
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(NextDeadline() - std::chrono::steady_clock::now());
    std::array<epoll_event, 16> events;
    const int count = epoll_wait(epoll_.fd(), events.data(), static_cast<int>(events.size()),
                                 static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 60'000)));
    for (int i = 0; i < count; ++i) {
      Turn(events[static_cast<std::size_t>(i)].data.u64);
    }
    Actions posted;
    {
      const std::scoped_lock lock(posted_mutex_);
      posted.swap(posted_);
    }
    for (const auto& action : posted) action();
    CountRound();
  }
}

void ShmCore::Turn(std::uint64_t mark) {
  if (mark == kListening) {
    AcceptPairs();
  } else if (mark == kWoken) {
    waker_.Clear();
  } else if (const auto pair = PairAt(static_cast<std::uint32_t>(mark))) {
    if ((mark & kProcess) != 0) {
      OnProcessEnd(pair);
    } else {
      Read(pair);
    }
  }
}

void ShmCore::TryDestinations(SteadyTime now) {
  std::vector<std::string> places;
  {
    const auto pairs = Pairs();
    const std::scoped_lock lock(mutex_);
    for (Destination& destination : destinations_) {
      if (destination.Connected() || now < destination.next_try) continue;
      destination.pause = std::clamp(destination.pause * 2, kFirstPause, kLongestPause);
      destination.next_try = now + destination.pause;
      const bool connected = std::ranges::any_of(pairs, [&](const auto& pair) {
        return pair->alive && destination.session.value != 0 && pair->facts.info.id == destination.session;
      });
      if (!connected) places.push_back(destination.place);
    }
  }
  for (const std::string& place : places) {
    std::string fault;
    Handle connection = ConnectTo(place, fault);
    if (!connection.valid()) continue;
    const auto pair = AddPair(std::move(connection), true, place);
    const std::scoped_lock lock(mutex_);
    for (Destination& destination : destinations_) {
      if (destination.place != place) continue;
      destination.pair = pair;
      destination.pause = std::chrono::milliseconds(0);
    }
  }
}

void ShmCore::AcceptPairs() {
  for (;;) {
    bool out_of_descriptors = false;
    Handle connection = AcceptFrom(listening_, out_of_descriptors);
    if (connection.valid()) {
      (void)AddPair(std::move(connection), false, {});
      continue;
    }
    if (!out_of_descriptors) return;
    // It stays readable: asking on would use up a CPU.
    listens_ = epoll_ctl(epoll_.fd(), EPOLL_CTL_DEL, listening_.fd(), nullptr) != 0;
    log_.WriteLimited(LogLevel::kWarning, "shm accept",
                      "Another session cannot be let in: the limit of open files is reached. Raise it (ulimit -n).");
    return;
  }
}

std::shared_ptr<Pair> ShmCore::AddPair(Handle connection, bool by_us, const std::string& place) {
  const auto refuse = [this](const std::string& why) -> std::shared_ptr<Pair> {
    log_.WriteLimited(LogLevel::kWarning, "shm refuse", "No memory is shared with another session: " + why + ".");
    return nullptr;
  };
  auto handle = std::make_shared<const Handle>(std::move(connection));
  std::string fault;
  std::unique_ptr<LaneWriter> lane = LaneWriter::Make(fault);
  if (!lane) return refuse(fault);
  std::shared_ptr<Slip> slip = Slip::Make(handle, fork_, fault);
  if (!slip) return refuse(fault);
  std::shared_ptr<Pair> pair;
  {
    const std::scoped_lock lock(pairs_mutex_);
    std::uint32_t number = 0;
    while (pairs_.contains(number)) ++number;
    if (number >= kMaxPeers) return refuse("there are " + std::to_string(kMaxPeers) + " already");
    pair = std::make_shared<Pair>(number, std::move(handle), by_us, kMaxHelloBytes);
    pairs_.emplace(number, pair);
  }
  if (const uid_t user = pair->socket.PeerUser(); user != geteuid()) {
    ForgetPair(pair);
    return refuse("it belongs to another user (" + std::to_string(user) + ")");
  }
  pair->process = pair->socket.PeerProcess();
  if (pair->process != getpid()) pair->process_end = WatchProcess(pair->process);
  pair->last_heard = pair->last_read = std::chrono::steady_clock::now();
  pair->place = place;
  pair->out = std::move(lane);
  pair->slip = std::move(slip);
  wire::PairMessage said;
  auto& hello = *said.mutable_hello();
  hello.set_session(self_.info.id.value);
  WriteFacts(self_, *hello.mutable_facts());
  hello.set_layout(kLayoutVersion);
  hello.set_bell_number(pair->number);
  {
    const std::scoped_lock lock(mutex_);
    pair->socket.Send(said, {bell_.handle(), pair->out->handle(), pair->slip->handle()});
  }
  if (!Watch(pair->socket.handle()->fd(), pair->number, EPOLLIN | EPOLLOUT | EPOLLET) ||
      (pair->process_end.valid() && !Watch(pair->process_end.fd(), kProcess | pair->number, EPOLLIN | EPOLLONESHOT))) {
    const int error = errno;
    ForgetPair(pair);
    return refuse(std::string("its socket cannot be waited for: ") + std::strerror(error));
  }
  return pair;
}

void ShmCore::Read(const std::shared_ptr<Pair>& pair) {
  {
    const std::scoped_lock lock(mutex_);
    pair->socket.Flush();
  }
  PairSocket::Frame frame;
  int left = kFramesAtOnce;
  for (bool more = true; more; --left) {
    if (left == 0) {
      PostFor(*pair, [this](const auto& same) { Read(same); });
      break;
    }
    switch (pair->socket.Receive(frame)) {
      case PairSocket::Read::kFrame:
        pair->last_read = std::chrono::steady_clock::now();
        OnFrame(pair, frame);
        break;
      case PairSocket::Read::kNothing: more = false; break;
      case PairSocket::Read::kFault:
        if (pair->alive) {
          Distrust(*pair, pair->socket.fault());
        } else if (!pair->ending) {
          log_.WriteLimited(LogLevel::kWarning, "shm refuse",
                            "No memory is shared with another session: " + pair->socket.fault() + ".");
          EndPair(pair, pair->socket.fault(), true);
        }
        break;  // What it holds of ours, it holds until its socket ends.
      case PairSocket::Read::kClosed:
        pair->eof = true;
        EndPair(pair, "its process has ended", false);
        more = false;
        break;
    }
  }
  bool look = false;
  {
    const std::scoped_lock lock(pair->in_mutex);
    look = std::exchange(pair->blocked, false);
  }
  if (look) bell_.Ring(pair->number);
}

// Its links out end now, those in behind what it has written.
void ShmCore::EndPair(const std::shared_ptr<Pair>& pair, const std::string& reason, bool say_bye) {
  if (pair->ending.load()) {
    if (pair->eof && pair->finished) ForgetPair(pair);
    return;
  }
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    if (!pair->alive) pair->eof = true;  // It was never given anything.
    pair->alive = false;
    pair->asks = false;
    if (say_bye) {
      wire::PairMessage bye;
      bye.mutable_bye()->set_reason(reason);
      pair->socket.Send(bye);
    }
    for (auto& [name, wish] : pair->wishes) RemoveLink(wish, true, actions);
    pair->wishes.clear();
  }
  pair->end_reason = reason;
  pair->ending = true;
  for (const auto& action : actions) action();
  bell_.Ring(pair->number);  // The reading thread takes what is left, and then has the pair finished.
}

// Whether or not its socket is still open in a child of its own.
void ShmCore::OnProcessEnd(const std::shared_ptr<Pair>& pair) {
  if (!HasEnded(pair->process_end)) return;  // The number was another pair's.
  Read(pair);
  if (pair->eof) return;
  pair->eof = true;
  EndPair(pair, "its process has ended", false);
}

void ShmCore::FinishPair(const std::shared_ptr<Pair>& pair) {
  Actions actions;
  std::shared_ptr<Slip> slip;
  {
    const std::scoped_lock lock(pair->in_mutex);
    for (const auto& [number, link] : pair->in_links) {
      if (link->granted) InboundCore::CountPublisher(link->core, -1, actions);
    }
    pair->in_links.clear();
    pair->in_channels.clear();
    pair->segments.clear();
    pair->apart.clear();
    pair->in.reset();
    slip = std::move(pair->slip);
  }
  for (const auto& action : actions) action();
  if (std::exchange(pair->came, false)) registry_.Gone(pair->facts.info, pair->end_reason);
  pair->finished = true;
  if (pair->eof) ForgetPair(pair);
}

void ShmCore::ForgetPair(const std::shared_ptr<Pair>& pair) {
  std::unique_ptr<LaneWriter> out;  // Ends without a lock: what it holds may be the user's.
  {
    const std::scoped_lock lock(mutex_, pairs_mutex_);
    const auto known = pairs_.find(pair->number);
    if (known == pairs_.end() || known->second != pair) return;
    out = std::move(pair->out);
    pairs_.erase(known);
    for (Destination& destination : destinations_) {
      if (destination.pair.lock() == pair) destination.pair.reset();
    }
  }
  epoll_ctl(epoll_.fd(), EPOLL_CTL_DEL, pair->socket.handle()->fd(), nullptr);
  if (pair->process_end.valid()) epoll_ctl(epoll_.fd(), EPOLL_CTL_DEL, pair->process_end.fd(), nullptr);
}

void ShmCore::Tick(SteadyTime now) {
  const bool overslept = now - next_tick_ > options_.heartbeat;
  next_tick_ = now + options_.heartbeat;
  if (!listens_) listens_ = Watch(listening_.fd(), kListening, EPOLLIN);
  const auto gone = pool_->TakeGone();
  std::vector<std::pair<std::shared_ptr<Pair>, std::string>> silent;
  Leavings leavings;
  for (const auto& pair : Pairs()) {
    bool beats = overslept;
    {
      const std::scoped_lock lock(mutex_, pair->in_mutex);
      if (!pair->out) continue;
      pair->out->Beat();
      if (pair->slip) pair->slip->Beat();
      Collect(*pair, leavings);
      for (auto& [name, wish] : pair->wishes) {
        if (wish.link) ReadCredit(*wish.link, leavings);
      }
      RemoveSegments(*pair, gone);
      const std::uint32_t heartbeat = pair->out->peer_heartbeat();
      beats = std::exchange(pair->seen_heartbeat, heartbeat) != heartbeat || beats;
      pair->socket.Flush();  // What failed may go now.
      if (!pair->blocked || overslept) pair->last_read = now;
    }
    if (pair->ending) continue;
    const std::string timeout = std::to_string(options_.peer_timeout.count()) + " ms";
    if (beats) {
      pair->last_heard = now;
    } else if (now - pair->last_heard > options_.peer_timeout) {
      silent.emplace_back(pair, (pair->alive ? "silent for " : "it did not greet for ") + timeout);
    }
    if (now - pair->last_read > options_.peer_timeout) {
      Distrust(*pair, "a message needs what was not passed on for " + timeout);
    }
    bell_.Ring(pair->number);  // In case a peer has taken a ring back.
  }
  bell_.Mend();
  for (const auto& [pair, reason] : silent) EndPair(pair, reason, true);
}

}  // namespace hgros::shm
