#include "transport/shm/pair/connections.hpp"

#include <sys/epoll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "hgros/base/error.hpp"

namespace hgros::shm {
namespace {

constexpr int kAcceptsAtOnce = 64;

std::string TextOfOther(uid_t user) { return "it belongs to another user (" + std::to_string(user) + ")"; }

}  // namespace

Connections::Connections(ShmSession& session, const Parts& parts)
    : session_(session),
      pairs_(parts.pairs),
      sockets_(parts.sockets),
      publisher_(parts.publisher),
      offered_(parts.offered),
      wanted_(parts.wanted),
      bell_(parts.bell),
      destinations_(parts.destinations),
      obstacles_(parts.obstacles),
      registry_(parts.registry),
      handshake_(session, parts.pairs, parts.publisher, parts.bell),
      next_beat_(std::chrono::steady_clock::now() + session.options.heartbeat) {
  std::string fault;
  listening_ = ListenAt(session_.options.place, fault);
  if (!listening_.valid()) {
    throw Error("Other sessions of this host cannot reach this one through shared memory: " + fault + ".", {},
                "Choose another place, or leave it empty to have one chosen.");
  }
  if (!sockets_.Watch(listening_, EPOLLIN, SocketThread::Source::kListening)) {
    throw Error(std::string("Cannot wait for a descriptor: ") + std::strerror(errno) + ".");
  }
}

SteadyTime Connections::DoWhatIsDue(SteadyTime now) {
  publisher_.NotifyClose();
  Connect(now);
  if (now >= next_beat_) Beat(now);
  return destinations_.NextTry(next_beat_);
}

void Connections::OnReady(SocketThread::Source source, std::uint32_t number) {
  if (source == SocketThread::Source::kListening) {
    Accept();
  } else if (const auto pair = pairs_.At(number)) {
    source == SocketThread::Source::kPairProcess ? OnProcessEnd(pair) : Read(pair);
  }
}

void Connections::Connect(SteadyTime now) {
  const auto is_connected = [this](SessionId session) {
    return std::ranges::any_of(pairs_.List(),
                               [&](const auto& pair) { return pair->alive && pair->facts.info.id == session; });
  };
  bool wait = true;  // Once in vain, so that many full places do not keep this thread.
  for (const std::string& place : destinations_.Due(now, is_connected)) {
    std::string fault;
    Handle connection = ConnectTo(place, fault, wait);
    if (connection.valid()) {
      destinations_.SetPair(place, AddPair(std::move(connection), true, place));
    } else {
      obstacles_.Set(place, {}, fault);
    }
  }
}

// The socket stays readable while more connections wait, and others have their turn between.
void Connections::Accept() {
  std::optional<uid_t> stranger;
  bool out_of_descriptors = false;
  for (int i = 0; i < kAcceptsAtOnce; ++i) {
    Handle connection = AcceptFrom(listening_, out_of_descriptors);
    if (!connection.valid()) break;
    // Any user can connect again and again, so nothing is made for others.
    const uid_t user = OtherSideOf(connection).user;
    if (user == geteuid()) {
      (void)AddPair(std::move(connection), false, {});
    } else {
      stranger = user;
    }
  }
  if (stranger) Refuse(TextOfOther(*stranger), {});
  if (!out_of_descriptors) return;
  // The socket stays readable: waiting for it would use up a CPU.
  listens_ = !sockets_.Unwatch(listening_);
  obstacles_.Set({}, {}, "this process can open no more files, so it cannot accept a connection (ulimit -n)");
  session_.log.WriteLimited(LogLevel::kWarning, "shm accept",
                            "Another session cannot connect: the limit of open files is reached. Raise it "
                            "(ulimit -n).");
}

void Connections::Refuse(const std::string& why, const std::string& place) {
  session_.log.WriteLimited(LogLevel::kWarning, "shm refuse", "No memory is shared with another session: " + why + ".");
  obstacles_.Set(place, {}, why);
}

// Null if the connection is refused.
std::shared_ptr<Pair> Connections::AddPair(Handle connection, bool by_us, const std::string& place) {
  const auto refuse = [&](const std::string& why) -> std::shared_ptr<Pair> {
    Refuse(why, place);
    return nullptr;
  };
  const OtherSide other = OtherSideOf(connection);
  if (other.user != geteuid()) return refuse(TextOfOther(other.user));
  auto handle = std::make_shared<const Handle>(std::move(connection));
  std::string fault;
  std::unique_ptr<LaneWriter> lane = LaneWriter::Make(fault);
  if (!lane) return refuse(fault);
  std::shared_ptr<Slip> slip = Slip::Make(handle, session_.fork, fault);
  if (!slip) return refuse(fault);
  const auto pair = std::make_shared<Pair>(std::move(handle), by_us, Handshake::kMaxHelloBytes, std::move(slip));
  pair->process = other.process;
  if (pair->process != getpid()) pair->process_end = WatchProcess(pair->process);
  pair->last_heard = pair->last_read = std::chrono::steady_clock::now();
  pair->place = place;
  pair->out.lane = std::move(lane);
  if (!pairs_.Add(pair)) return refuse("there are " + std::to_string(kMaxPeers) + " already");
  handshake_.SayHello(*pair);
  using Source = SocketThread::Source;
  if (!sockets_.Watch(*pair->socket.handle(), EPOLLIN | EPOLLOUT | EPOLLET, Source::kPair, pair->number) ||
      (pair->process_end.valid() &&
       !sockets_.Watch(pair->process_end, EPOLLIN | EPOLLONESHOT, Source::kPairProcess, pair->number))) {
    const int error = errno;
    ForgetPair(pair);
    return refuse(std::string("its socket cannot be waited for: ") + std::strerror(error));
  }
  return pair;
}

// Outgoing links end now. Incoming links end after the messages that it has written.
void Connections::EndPair(const std::shared_ptr<Pair>& pair, const std::string& reason, bool say_bye, LinkEnd links) {
  if (pair->ending.load()) {
    if (pair->eof && pair->finished) ForgetPair(pair);
    return;
  }
  if (!pair->alive) pair->eof = true;  // It was never given anything.
  obstacles_.Set(pair->place, pair->facts.info.id, reason);
  Actions actions;
  pair->alive = false;
  wanted_.StopAsking(*pair);
  offered_.EndPair(*pair, links, actions);
  if (say_bye) {
    wire::PairMessage bye;
    bye.mutable_bye()->set_reason(reason);
    pair->socket.Send(bye);
  }
  pair->end_reason = reason;
  pair->ending = true;
  for (const auto& action : actions) action();
  bell_.Ring(pair->number);  // The reading thread reads the rest, and then finishes the pair.
}

void Connections::OnLie(const std::shared_ptr<Pair>& liar, const std::string& what) {
  if (liar->ending.load()) return;
  session_.CountFault(PacketFault::kHead);
  session_.log.WriteLimited(
      LogLevel::kWarning, "shm lie " + what,
      "The shared memory of " + NameOf(*liar) + " is invalid: " + what + ". The connection ends and is made again.");
  liar->in.StopReading();
  EndPair(liar, "its shared memory is invalid", true);
}

// This works even if a child of the process still has the socket open.
void Connections::OnProcessEnd(const std::shared_ptr<Pair>& pair) {
  if (!HasEnded(pair->process_end)) return;  // The event belongs to an earlier pair with this number.
  Read(pair);
  if (pair->eof) return;
  pair->eof = true;
  EndPair(pair, "its process has ended", false);
}

void Connections::OnAllRead(const std::shared_ptr<Pair>& pair) {
  Actions actions;
  const auto links = pair->in.Clear();
  for (const auto& link : links) {
    if (link->granted) InboundCore::CountPublisher(link->core, pair->facts.info.id, -1, actions);
  }
  for (const auto& action : actions) action();
  pair->in.MarkEnded();
  if (std::exchange(pair->announced, false)) registry_.Gone(pair->facts.info, pair->end_reason);
  for (const auto& other : pairs_.List()) {
    if (other->facts.info.id == pair->facts.info.id) bell_.Ring(other->number);  // It may have waited for this one.
  }
  pair->finished = true;
  if (pair->eof) ForgetPair(pair);
}

void Connections::ForgetPair(const std::shared_ptr<Pair>& pair) {
  if (!pairs_.Remove(pair)) return;
  const auto ends = publisher_.ReleaseLane(*pair);  // Destroyed without a lock: this may run user code.
  destinations_.ForgetPair(pair);
  (void)sockets_.Unwatch(*pair->socket.handle());
  if (pair->process_end.valid()) (void)sockets_.Unwatch(pair->process_end);
}

void Connections::Beat(SteadyTime now) {
  const bool overslept = now - next_beat_ > session_.options.heartbeat;
  const auto patience = session_.options.peer_timeout;
  const std::string timeout = std::to_string(patience.count()) + " ms";
  next_beat_ = now + session_.options.heartbeat;
  if (!listens_) listens_ = sockets_.Watch(listening_, EPOLLIN, SocketThread::Source::kListening);
  const auto removed = publisher_.pool().CollectRemovedSegments();
  std::vector<std::pair<std::shared_ptr<Pair>, std::string>> silent;
  for (const auto& pair : pairs_.List()) {
    const std::uint32_t heartbeat = publisher_.Beat(*pair, removed);
    // A peer that reads a large message from its socket may have no time for its heartbeat. One that reads nothing
    // seems to read until the socket is full.
    const std::uint64_t sent = pair->socket.sent_bytes();
    const bool reads = std::exchange(pair->seen_sent_bytes, sent) != sent;
    const bool beats = std::exchange(pair->seen_heartbeat, heartbeat) != heartbeat || reads || overslept;
    pair->in.Beat();
    if (pair->socket.Flush()) sockets_.FlushSoon(*pair);  // Sends what the socket did not accept before.
    if (!pair->in.blocked() || overslept) pair->last_read = now;
    if (pair->ending) continue;
    if (beats) {
      pair->last_heard = now;
    } else if (now - pair->last_heard > patience) {
      silent.emplace_back(pair, (pair->alive ? "it was silent for " : "it did not greet for ") + timeout);
    }
    if (now - pair->last_read > patience) {
      sockets_.Distrust(*pair, "a message needs a segment or payload that did not come for " + timeout);
    }
    bell_.Ring(pair->number);  // In case another peer has cleared its bit.
  }
  bell_.Mend();
  // Publishers do not wait any longer for a silent peer.
  for (const auto& [pair, reason] : silent) EndPair(pair, reason, true, LinkEnd::kForGood);
}

void Connections::Close(Actions& nobody_listens) {
  wire::PairMessage bye;
  bye.mutable_bye()->set_reason("the session ends");
  const auto pairs = pairs_.RemoveAll();
  for (const auto& pair : pairs) {
    wanted_.StopAsking(*pair);
    const bool alive = pair->alive.exchange(false);
    offered_.EndPair(*pair, LinkEnd::kForGood, nobody_listens);
    if (alive) pair->socket.Send(bye);
  }
  for (const auto& pair : pairs) {
    if (std::exchange(pair->announced, false)) registry_.Gone(pair->facts.info, "this session ends");
  }
  listening_ = {};
}

}  // namespace hgros::shm
