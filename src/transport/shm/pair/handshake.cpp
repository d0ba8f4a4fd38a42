#include "transport/shm/pair/handshake.hpp"

#include <utility>

#include "hgros/internal/codec/packet.hpp"

namespace hgros::shm {

void Handshake::SayHello(Pair& pair) {
  wire::PairMessage said;
  auto& hello = *said.mutable_hello();
  hello.set_session(session_.self.info.id.value);
  WriteFacts(session_.self, *hello.mutable_facts());
  hello.set_layout(kLayoutVersion);
  hello.set_bell_number(pair.number);
  hello.set_max_message_bytes(session_.options.max_message_bytes);
  pair.socket.Send(said, {bell_.handle(), pair.out.lane->handle(), pair.in.slip_handle()});
}

Handshake::Outcome Handshake::OnHello(Pair& pair, PairSocket::Frame& frame) {
  const wire::PairHello& hello = frame.message.hello();
  if (pair.greeted || pair.ending) return {.step = Outcome::Step::kLie, .reason = "it greets twice"};
  pair.facts = ReadFacts(SessionId{hello.session()}, hello.facts());
  pair.facts.info.endpoint = pair.place;
  Outcome outcome = CompareWithOthers(pair);
  if (outcome.step == Outcome::Step::kRefuse) return outcome;
  if (std::string fault = OpenPages(pair, hello, frame); !fault.empty()) {
    session_.CountFault(PacketFault::kVersion);
    session_.log.WriteLimited(LogLevel::kWarning, "shm hello " + fault,
                              "No memory is shared with " + NameOf(pair) + ": " + fault + ".");
    outcome.step = Outcome::Step::kRefuse;
    outcome.reason = std::move(fault);
    return outcome;
  }
  pair.greeted = true;
  pair.socket.SetMaxFrame(session_.options.max_message_bytes + kFrameOverheadBytes);
  if (pair.facts.info.id.value < session_.self.info.id.value) return outcome;  // The peer chooses the connection.
  wire::PairMessage said;
  said.mutable_welcome();
  pair.socket.Send(said);
  outcome.step = Outcome::Step::kBegin;
  return outcome;
}

Handshake::Outcome Handshake::OnWelcome(const Pair& pair) const {
  const SessionId peer = pair.facts.info.id;
  if (!pair.greeted || pair.alive || pair.ending || session_.self.info.id.value < peer.value) {
    return {.step = Outcome::Step::kLie, .reason = "it chooses the connection, and that is not its task"};
  }
  Outcome outcome{.step = Outcome::Step::kBegin};
  for (const auto& other : pairs_.List()) {
    if (other.get() != &pair && other->alive && other->facts.info.id == peer) outcome.replaced.push_back(other);
  }
  return outcome;
}

// Refuses the pair if another connection stays; otherwise waits.
Handshake::Outcome Handshake::CompareWithOthers(const Pair& pair) const {
  const SessionId peer = pair.facts.info.id;
  Outcome outcome;
  const auto refuse = [&](std::string why) {
    outcome.step = Outcome::Step::kRefuse;
    outcome.reason = std::move(why);
    return outcome;
  };
  if (peer.value == 0) return refuse("it has no id");
  if (peer == session_.self.info.id) return refuse("it is this session");
  for (const auto& other : pairs_.List()) {
    if (other.get() == &pair || !other->alive || other->facts.info.id != peer) continue;
    if (other->process != pair.process && other->process_end.valid() && !HasEnded(other->process_end)) {
      session_.log.WriteLimited(LogLevel::kWarning, "shm id",
                                "Another process uses the id of " + NameOf(*other) +
                                    ": no memory is shared with it. Give each session its own id, or none.");
      return refuse("another process has its id");
    }
    if (peer.value < session_.self.info.id.value) continue;
    if (other->facts.incarnation == pair.facts.incarnation) return refuse("it is connected already");
    outcome.replaced.push_back(other);
  }
  return outcome;
}

// Empty: the pages are valid.
std::string Handshake::OpenPages(Pair& pair, const wire::PairHello& hello, PairSocket::Frame& frame) {
  if (hello.facts().wire_major() != kWireMajor || hello.layout() != kLayoutVersion) {
    return "it has another version (wire " + std::to_string(hello.facts().wire_major()) + ", layout " +
           std::to_string(hello.layout()) + "; here " + std::to_string(kWireMajor) + ", " +
           std::to_string(kLayoutVersion) + "); use one version of the library";
  }
  if (frame.handles_lost) return "the limit of open files is reached; raise it (ulimit -n)";
  if (frame.handles.size() != 3) return "it did not send its memory";
  std::string fault;
  std::shared_ptr<const PeerBell> bell = PeerBell::Open(frame.handles[0], hello.bell_number(), fault);
  auto lane = bell ? LaneReader::Open(frame.handles[1], fault) : nullptr;
  const std::uint64_t limit = hello.max_message_bytes() > 0 ? hello.max_message_bytes() : ~std::uint64_t{0};
  if (!lane || !publisher_.OpenPair(pair, frame.handles[2], bell, limit, fault)) {
    return "its shared memory is wrong: " + fault;
  }
  pair.in.Open(std::move(lane), std::move(bell), pair.facts.info.id);
  return {};
}

}  // namespace hgros::shm
