// How pairs begin and end. All on the core's own thread.
#include <sys/epoll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "transport/shm/shm_core.hpp"

namespace hgros::shm {
namespace {

// Who has not greeted yet says no more than that at once.
constexpr std::size_t kMaxHelloBytes = 64 * 1024;
constexpr int kFramesAtOnce = 256;  // Of one peer before others have their turn.
constexpr auto kFirstPause = std::chrono::milliseconds(100);
constexpr auto kLongestPause = std::chrono::milliseconds(1000);

}  // namespace

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
  hello.set_max_message_bytes(options_.max_message_bytes);
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
  const std::uint64_t before = pair->socket.received_bytes();
  int left = kFramesAtOnce;
  for (bool more = true; more; --left) {
    if (left == 0) {
      PostFor(*pair, [this](const auto& same) { Read(same); });
      break;
    }
    switch (pair->socket.Receive(frame)) {
      case PairSocket::Read::kFrame: OnFrame(pair, frame); break;
      case PairSocket::Read::kMore: break;
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
  // Also of a frame that takes long to come. Who has not greeted has no such time.
  if (pair->socket.received_bytes() != before) {
    pair->last_read = std::chrono::steady_clock::now();
    if (pair->greeted) pair->last_heard = pair->last_read;
  }
  bool look = false;
  {
    const std::scoped_lock lock(pair->in_mutex);
    look = std::exchange(pair->blocked, false);
  }
  if (look) bell_.Ring(pair->number);
}

// Its links out end now, those in behind what it has written.
void ShmCore::EndPair(const std::shared_ptr<Pair>& pair, const std::string& reason, bool say_bye, LinkEnd links) {
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
    for (auto& [name, wish] : pair->wishes) RemoveLink(wish, links, actions);
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
  for (const auto& other : Pairs()) {
    if (other->facts.info.id == pair->facts.info.id) bell_.Ring(other->number);  // It may have waited for this one.
  }
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
        if (!wish.link) continue;
        ReadCredit(*wish.link, leavings);
        SayTooLarge(*wish.link);
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
      silent.emplace_back(pair, (pair->alive ? "it was silent for " : "it did not greet for ") + timeout);
    }
    if (now - pair->last_read > options_.peer_timeout) {
      Distrust(*pair, "a message needs what was not passed on for " + timeout);
    }
    bell_.Ring(pair->number);  // In case a peer has taken a ring back.
  }
  bell_.Mend();
  // It has held publishers up for long enough.
  for (const auto& [pair, reason] : silent) EndPair(pair, reason, true, LinkEnd::kForGood);
}

}  // namespace hgros::shm
