// Reads frames from the sockets of pairs.
#include <utility>

#include "hgros/base/readable_text.hpp"
#include "transport/shm/pair/connections.hpp"

namespace hgros::shm {
namespace {

constexpr int kFramesPerTurn = 256;  // From one peer, before others have their turn.

}  // namespace

void Connections::Read(const std::shared_ptr<Pair>& pair) {
  if (pair->socket.Flush()) sockets_.FlushSoon(*pair);
  PairSocket::Frame frame;
  const std::uint64_t before = pair->socket.received_bytes();
  int left = kFramesPerTurn;
  for (bool more = true; more; --left) {
    if (left == 0) {
      sockets_.PostFor(*pair, [this](const auto& same) { Read(same); });
      break;
    }
    switch (pair->socket.Receive(frame)) {
      case PairSocket::Read::kFrame: OnFrame(pair, frame); break;
      case PairSocket::Read::kMore: break;
      case PairSocket::Read::kNothing: more = false; break;
      case PairSocket::Read::kFault:
        if (pair->alive) {
          sockets_.Distrust(*pair, pair->socket.fault());
        } else if (!pair->ending) {
          Refuse(pair->socket.fault(), pair->place);
          EndPair(pair, pair->socket.fault(), true);
        }
        break;  // The peer may hold messages of ours until its socket ends.
      case PairSocket::Read::kClosed:
        pair->eof = true;
        EndPair(pair, pair->greeted ? "its process has ended" : "it closed the connection, and may have logged why",
                false);
        more = false;
        break;
    }
  }
  // Bytes of an unfinished frame count as well, except before the greeting.
  if (pair->socket.received_bytes() != before) {
    pair->last_read = std::chrono::steady_clock::now();
    if (pair->greeted) pair->last_heard = pair->last_read;
  }
  if (pair->in.Unblock()) bell_.Ring(pair->number);
}

void Connections::OnFrame(const std::shared_ptr<Pair>& pair, PairSocket::Frame& frame) {
  if (frame.payload) {
    if (pair->alive && !pair->in.AddPayload(std::move(*frame.payload))) {
      sockets_.Distrust(*pair, "it sends payloads that no message needs");
    }
    return;
  }
  const wire::PairMessage& said = frame.message;
  if (said.has_hello()) {
    OnHello(pair, frame);
    return;
  }
  if (said.has_welcome()) {
    Follow(pair, handshake_.OnWelcome(*pair));
    return;
  }
  if (said.has_bye()) {
    // Before the pair begins, the reason is why the other side refuses it.
    EndPair(
        pair,
        pair->alive ? "it said goodbye" : "it refuses the connection: " + Readable(said.bye().reason(), kMaxTextBytes),
        false);
    return;
  }
  if (!pair->alive) return;
  switch (said.what_case()) {
    case wire::PairMessage::kWish: offered_.OnWish(*pair, said.wish()); break;
    case wire::PairMessage::kUnwish: offered_.OnUnwish(*pair, said.unwish()); break;
    case wire::PairMessage::kGranted: wanted_.OnGranted(*pair, said.granted()); break;
    case wire::PairMessage::kMisfit: wanted_.OnMisfit(*pair, said.misfit()); break;
    case wire::PairMessage::kEnded: wanted_.OnEnded(*pair, said.ended()); break;
    case wire::PairMessage::kTooLarge:
      if (!wanted_.OnTooLarge(*pair, said.too_large())) {
        sockets_.Distrust(*pair, "it reports messages that cannot be too large");
      }
      break;
    case wire::PairMessage::kSegmentAdded: OnSegment(*pair, said.segment_added().segment(), frame); break;
    case wire::PairMessage::kSegmentRefused: publisher_.ResendApart(*pair, said.segment_refused().segment()); break;
    case wire::PairMessage::kSegmentRemoved: pair->in.RemoveSegment(said.segment_removed().segment()); break;
    default: break;  // From a newer version.
  }
}

void Connections::OnHello(const std::shared_ptr<Pair>& pair, PairSocket::Frame& frame) {
  const Handshake::Outcome outcome = handshake_.OnHello(*pair, frame);
  if (pair->by_us && outcome.step != Handshake::Outcome::Step::kLie) {
    destinations_.SetSession(pair->place, pair->facts.info.id);
  }
  if (pair->greeted) pair->last_heard = std::chrono::steady_clock::now();
  Follow(pair, outcome);
}

void Connections::Follow(const std::shared_ptr<Pair>& pair, const Handshake::Outcome& outcome) {
  using Step = Handshake::Outcome::Step;
  for (const auto& other : outcome.replaced) EndPair(other, "a newer connection took its place", true);
  switch (outcome.step) {
    case Step::kBegin: BeginPair(pair); break;
    case Step::kWait: break;
    case Step::kRefuse: EndPair(pair, outcome.reason, true); break;
    case Step::kLie: sockets_.Distrust(*pair, outcome.reason); break;
  }
}

void Connections::BeginPair(const std::shared_ptr<Pair>& pair) {
  pair->announced = true;
  registry_.Came(pair->facts.info);
  obstacles_.Clear(pair->place, pair->facts.info.id);
  destinations_.ResetPause(pair->place);
  for (const auto& other : pairs_.List()) {
    if (!other->ending || other->in.ended() || other->facts.info.id != pair->facts.info.id) continue;
    pair->in.ReadAfter(std::shared_ptr<const PairInbox>(other, &other->in));
  }
  pair->alive = true;
  wanted_.AskPair(*pair);
}

void Connections::OnSegment(Pair& pair, std::uint32_t segment, PairSocket::Frame& frame) {
  std::string fault = frame.handles_lost ? "the limit of open files is reached" : "it comes without a descriptor";
  bool no_room = frame.handles_lost;
  auto mapping = frame.handles.size() == 1 ? MapForeign(frame.handles[0], 0, false, fault, &no_room) : nullptr;
  if (!mapping && no_room) {
    wire::PairMessage said;
    said.mutable_segment_refused()->set_segment(segment);
    pair.socket.Send(said);
    session_.log.WriteLimited(
        LogLevel::kWarning, "shm map",
        "This process cannot map the shared memory of " + NameOf(pair) + ": " + fault +
            ". Messages in it come over a socket, which is slower, until it can. Raise the limits "
            "of memory and open files of this process.",
        std::chrono::hours(1));
  } else if (!mapping) {
    sockets_.Distrust(pair, "a segment is wrong: " + fault);
  } else if (!pair.in.AddSegment(segment, std::move(mapping))) {
    sockets_.Distrust(pair, "it sends a segment twice, or too many segments");
  }
}

}  // namespace hgros::shm
