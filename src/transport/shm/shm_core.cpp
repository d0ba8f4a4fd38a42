#include "transport/shm/shm_core.hpp"

#include <sys/epoll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "hgros/base/error.hpp"

namespace hgros::shm {
namespace {

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
      for (auto& [name, wish] : pair->wishes) RemoveLink(wish, LinkEnd::kForGood, nobody_listens);
      pair->wishes.clear();
    }
  }
  for (const auto& [number, pair] : pairs) {
    if (std::exchange(pair->came, false)) registry_.Gone(pair->facts.info, "this session ends");
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

void ShmCore::Offer(const std::shared_ptr<OutChannel>& core) {
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    RequireNew(channels_, core->name, "advertised");
    channels_.emplace(core->name, core);
    if (closed_) return;
    for (const auto& pair : Pairs()) {
      const auto wish = pair->wishes.find(core->name);
      if (pair->alive && wish != pair->wishes.end() && !wish->second.link) Activate(*pair, wish->second, actions);
    }
  }
  Post(std::move(actions));
}

void ShmCore::Withdraw(const std::shared_ptr<OutChannel>& core) {
  Actions nobody_listens;
  {
    const std::scoped_lock lock(mutex_);
    const auto found = channels_.find(core->name);
    if (found != channels_.end() && found->second == core) {
      while (!core->links.empty()) {
        OutLink& link = *core->links.back();
        Pair& pair = link.pair;
        wire::PairMessage said;
        said.mutable_ended()->set_link(link.link);
        said.mutable_ended()->set_messages(link.flow.sent());
        pair.socket.Send(said);
        RemoveLink(pair.wishes.at(core->name), LinkEnd::kForGood, nobody_listens);
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
    if (pair->asks && Takes(*pair, core->name)) Ask(*pair, core);
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

}  // namespace hgros::shm
