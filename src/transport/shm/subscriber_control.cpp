// What publishing peers say, and how a pair begins. All on the core's own thread, but for what Want() and its like
// call.
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "hgros/codec/packet.hpp"
#include "transport/shm/shm_core.hpp"

namespace hgros::shm {
namespace {

constexpr std::size_t kMaxTold = 1024;

std::string Who(const Pair& pair) {
  return pair.facts.info.process + " (session " + pair.facts.info.id.ToString() + ")";
}

}  // namespace

void ShmCore::OnFrame(const std::shared_ptr<Pair>& pair, PairSocket::Frame& frame) {
  const wire::PairMessage& said = frame.message;
  if (said.has_hello()) {
    OnHello(pair, frame);
    return;
  }
  if (said.has_welcome()) {
    OnWelcome(pair);
    return;
  }
  if (said.has_bye()) {
    EndPair(pair, "it said goodbye", false);
    return;
  }
  if (!pair->alive) return;
  switch (said.what_case()) {
    case wire::PairMessage::kWish: OnWish(*pair, said.wish()); break;
    case wire::PairMessage::kUnwish: OnUnwish(*pair, said.unwish()); break;
    case wire::PairMessage::kGranted: OnGranted(*pair, said.granted()); break;
    case wire::PairMessage::kMisfit: OnMisfit(*pair, said.misfit()); break;
    case wire::PairMessage::kEnded: OnEnded(*pair, said.ended()); break;
    case wire::PairMessage::kSegmentAdded: OnSegment(*pair, said.segment_added().segment(), frame); break;
    case wire::PairMessage::kSegmentRemoved: {
      const std::scoped_lock lock(pair->in_mutex);
      pair->segments.erase(said.segment_removed().segment());
      break;
    }
    case wire::PairMessage::kPayload: OnPayload(*pair, *frame.message.mutable_payload()); break;
    case wire::PairMessage::kTooLarge: OnTooLarge(*pair, said.too_large()); break;
    default: break;  // Of a newer version.
  }
}

void ShmCore::OnHello(const std::shared_ptr<Pair>& pair, PairSocket::Frame& frame) {
  const wire::PairHello& hello = frame.message.hello();
  if (pair->greeted || pair->ending) {
    Distrust(*pair, "it greets twice");
    return;
  }
  pair->facts = ReadFacts(SessionId{hello.session()}, hello.facts());
  pair->facts.info.endpoint = pair->place;
  if (pair->by_us) {
    const std::scoped_lock lock(mutex_);
    for (Destination& destination : destinations_) {
      if (destination.place == pair->place) destination.session = pair->facts.info.id;
    }
  }
  if (const std::string why = WhyNot(*pair); !why.empty()) {
    EndPair(pair, why, true);
    return;
  }
  if (const std::string fault = OpenPages(*pair, hello, frame); !fault.empty()) {
    faults_[static_cast<std::size_t>(PacketFault::kVersion)].fetch_add(1, std::memory_order_relaxed);
    log_.WriteLimited(LogLevel::kWarning, "shm hello " + pair->facts.info.id.ToString(),
                      "No memory is shared with " + Who(*pair) + ": " + fault + ".");
    EndPair(pair, fault, true);
    return;
  }
  pair->greeted = true;
  pair->socket.SetMaxFrame(options_.max_message_bytes + kFrameOverheadBytes);
  pair->last_heard = std::chrono::steady_clock::now();
  if (pair->facts.info.id.value < self_.info.id.value) return;  // It says which connection stays.
  {
    const std::scoped_lock lock(mutex_);
    wire::PairMessage said;
    said.mutable_welcome();
    pair->socket.Send(said);
  }
  BeginPair(pair);
}

void ShmCore::OnWelcome(const std::shared_ptr<Pair>& pair) {
  if (!pair->greeted || pair->alive || self_.info.id.value < pair->facts.info.id.value) {
    Distrust(*pair, "it says which connection stays, and it is not its turn");
    return;
  }
  for (const auto& other : Pairs()) {
    if (other != pair && other->alive && other->facts.info.id == pair->facts.info.id) {
      EndPair(other, "another connection took its place", true);
    }
  }
  BeginPair(pair);
}

void ShmCore::BeginPair(const std::shared_ptr<Pair>& pair) {
  pair->came = true;
  registry_.Came(pair->facts.info);
  const std::scoped_lock lock(mutex_);
  for (Destination& destination : destinations_) {
    if (destination.place == pair->place) destination.pause = std::chrono::milliseconds(0);
  }
  for (const auto& other : Pairs()) {
    if (!other->ending || other->finishing || other->facts.info.id != pair->facts.info.id) continue;
    const std::scoped_lock in_lock(pair->in_mutex);
    pair->after.push_back(other);
  }
  pair->alive = true;
  AskForAll(*pair);
}

// Empty: all is well.
std::string ShmCore::OpenPages(Pair& pair, const wire::PairHello& hello, PairSocket::Frame& frame) {
  if (hello.facts().wire_major() != kWireMajor || hello.layout() != kLayoutVersion) {
    return "it is of another version (wire " + std::to_string(hello.facts().wire_major()) + ", layout " +
           std::to_string(hello.layout()) + "; here " + std::to_string(kWireMajor) + ", " +
           std::to_string(kLayoutVersion) + "); use one version of the library";
  }
  if (frame.handles.size() != 3) return "it did not pass its memory on";
  std::string fault;
  std::shared_ptr<const PeerBell> bell = PeerBell::Open(frame.handles[0], hello.bell_number(), fault);
  auto lane = bell ? LaneReader::Open(frame.handles[1], fault) : nullptr;
  const std::scoped_lock lock(mutex_);
  if (!lane || !pair.out->Open(frame.handles[2], fault)) return "of its shared memory, " + fault;
  pair.bell = std::move(bell);
  pair.max_message_bytes = hello.max_message_bytes() > 0 ? hello.max_message_bytes() : ~std::uint64_t{0};
  const std::scoped_lock in_lock(pair.in_mutex);
  pair.slip->SetPublisher(lane->mapping(), pair.bell);
  pair.in = std::move(lane);
  return {};
}

// Why the connection is not wanted; empty: it is.
//
// Two sessions may connect to each other at the same time, and both connections may be half made. The session with the
// smaller id chooses the first whose hello it reads; the other one begins nothing before it is told. Nobody puts an end
// to the connection of another living process by using its id.
std::string ShmCore::WhyNot(Pair& pair) {
  const SessionId peer = pair.facts.info.id;
  if (peer.value == 0) return "it has no id";
  if (peer == self_.info.id) return "it is this session";
  for (const auto& other : Pairs()) {
    if (other.get() == &pair || !other->alive || other->facts.info.id != peer) continue;
    if (other->process != pair.process && other->process_end.valid() && !HasEnded(other->process_end)) {
      log_.WriteLimited(LogLevel::kWarning, "shm id " + peer.ToString(),
                        "Another process uses the id of " + Who(*other) +
                            ": no memory is shared with it. Give each session an id of its own, or none.");
      return "another process has its id";
    }
    if (peer.value < self_.info.id.value) continue;
    if (other->facts.incarnation == pair.facts.incarnation) return "it is connected already";
    EndPair(other, "another life of it took its place", true);
  }
  return {};
}

void ShmCore::AskForAll(Pair& pair) {
  pair.asks = true;
  for (const auto& [name, core] : inbound_) {
    bool asked = false;
    {
      const std::scoped_lock lock(pair.in_mutex);
      asked = pair.in_channels.contains(name);
    }
    if (!asked && Takes(pair, name)) Ask(pair, core);
  }
}

bool ShmCore::Takes(const Pair& pair, const std::string& channel) const {
  return !options_.takes || options_.takes(pair.facts.info.id, channel);
}

void ShmCore::Ask(Pair& pair, const std::shared_ptr<InboundCore>& core) {
  const std::scoped_lock lock(pair.in_mutex);
  auto link = std::make_shared<InLink>();
  link->core = core;
  link->receipt = Receipt::Make(pair.slip);
  if (!link->receipt) {
    log_.WriteLimited(LogLevel::kError, "shm cells",
                      "More than " + std::to_string(kCells) + " channels are subscribed to at " + Who(pair) + ": \"" +
                          core->name + "\" does not come through shared memory. Subscribe to fewer channels.");
    return;
  }
  link->link = ++pair.last_link;
  pair.in_links.emplace(link->link, link);
  pair.in_channels[core->name] = link->link;
  SayWish(pair, *link);
}

void ShmCore::SayWish(Pair& pair, InLink& link) {
  const Demand demand = link.core->demand();
  link.asked_messages = std::max<std::uint64_t>(link.asked_messages, demand.credit_messages);
  link.asked_bytes = std::max(link.asked_bytes, demand.credit_bytes);
  wire::PairMessage said;
  auto& wish = *said.mutable_wish();
  wish.set_link(link.link);
  WriteType(link.core->name, link.core->type, *wish.mutable_wanted());
  wish.set_cell(link.receipt->cell());
  wish.set_lossless(demand.lossless);
  wish.set_queue_depth(demand.queue_depth);
  wish.set_credit_messages(demand.credit_messages);
  wish.set_credit_bytes(demand.credit_bytes);
  pair.socket.Send(said);
}

void ShmCore::ForgetWish(Pair& pair, const std::string& channel, std::string_view mismatch, Actions& actions) {
  const std::scoped_lock lock(pair.in_mutex);
  const auto found = pair.in_channels.find(channel);
  if (found == pair.in_channels.end()) return;
  const auto link = pair.in_links.at(found->second);
  pair.apart.erase(pair.apart.lower_bound({link->link, 0}), pair.apart.lower_bound({link->link + 1, 0}));
  pair.in_links.erase(found->second);
  pair.in_channels.erase(found);
  wire::PairMessage said;
  said.mutable_unwish()->set_link(link->link);
  said.mutable_unwish()->set_mismatch(mismatch.data(), std::min(mismatch.size(), kMaxTextBytes));
  pair.socket.Send(said);
  if (link->granted) InboundCore::CountPublisher(link->core, -1, actions);
}

void ShmCore::OnGranted(Pair& pair, const wire::Granted& granted) {
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    std::shared_ptr<InLink> link;
    {
      const std::scoped_lock in_lock(pair.in_mutex);
      const auto found = pair.in_links.find(granted.link());
      if (found == pair.in_links.end()) return;
      link = found->second;
    }
    const TypeInfo& type = link->core->type;
    std::string fault;
    if (!link->granted) {
      switch (CompareTypes(granted.offered(), type)) {
        case TypeFit::kEqual: break;
        case TypeFit::kEvolved:
          fault = SchemaFault(granted.descriptor_set(), type);
          if (!fault.empty()) break;
          log_.Write(LogLevel::kInfo, "Channel " + link->core->name + ": " + pair.facts.info.process +
                                          " publishes another, compatible version of " + type.name + ".");
          break;
        case TypeFit::kDiffer: fault = "the types differ"; break;
      }
    }
    if (!fault.empty()) {
      const std::string what = DescribeMismatch(granted.offered(), type) + ": " + fault;
      ForgetWish(pair, link->core->name, what, actions);
      actions.emplace_back([this, &pair, channel = link->core->name, what] { TellMismatch(pair, channel, what); });
    } else {
      const std::scoped_lock in_lock(pair.in_mutex);
      link->receipt->SetWindow(std::min<std::uint64_t>(granted.credit_messages(), link->asked_messages),
                               std::min(granted.credit_bytes(), link->asked_bytes));
      link->type_name = granted.offered().type_name();
      if (!IsAnyType(type)) link->encoding = type.encoding;  // Compared.
      link->fingerprint = granted.offered().fingerprint();
      if (!link->granted && (IsAnyType(type) || !granted.descriptor_set().empty())) {
        link->schema = ReadSchema(granted.offered(), granted.descriptor_set());
        if (IsAnyType(type)) link->encoding = link->schema->encoding;
        InboundCore::TellOffer(link->core, pair.facts.info, link->schema, actions);
      }
      if (!std::exchange(link->granted, true)) InboundCore::CountPublisher(link->core, 1, actions);
    }
  }
  for (const auto& action : actions) action();
}

void ShmCore::OnMisfit(Pair& pair, const wire::Misfit& misfit) {
  std::shared_ptr<InLink> link;
  {
    const std::scoped_lock lock(pair.in_mutex);
    const auto found = pair.in_links.find(misfit.link());
    if (found == pair.in_links.end() || found->second->granted) return;
    link = found->second;
  }
  TellMismatch(pair, link->core->name, DescribeMismatch(misfit.offered(), link->core->type));
}

void ShmCore::OnEnded(Pair& pair, const wire::Ended& ended) {
  bool now = false;
  {
    const std::scoped_lock lock(pair.in_mutex);
    const auto found = pair.in_links.find(ended.link());
    if (found == pair.in_links.end()) return;
    found->second->ends_after = ended.messages();
    now = found->second->receipt->received() >= ended.messages();
  }
  if (now) EndLink(pair, ended.link());
}

void ShmCore::EndLink(Pair& pair, std::uint64_t number) {
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    std::shared_ptr<InboundCore> core;
    {
      const std::scoped_lock in_lock(pair.in_mutex);
      const auto found = pair.in_links.find(number);
      if (found == pair.in_links.end()) return;
      core = found->second->core;
    }
    ForgetWish(pair, core->name, {}, actions);
    const auto wanted = inbound_.find(core->name);
    const bool still = wanted != inbound_.end() && wanted->second == core;
    if (pair.asks && still && Takes(pair, core->name)) Ask(pair, core);
  }
  for (const auto& action : actions) action();
}

void ShmCore::OnSegment(Pair& pair, std::uint32_t segment, PairSocket::Frame& frame) {
  std::string fault = "it comes without a descriptor";
  auto mapping = frame.handles.size() == 1 ? MapForeign(frame.handles[0], 0, false, fault) : nullptr;
  if (!mapping) {
    Distrust(pair, "of a segment, " + fault);
    return;
  }
  const std::scoped_lock lock(pair.in_mutex);
  if (segment == 0 || segment == kOnSocket || pair.segments.size() >= 2 * kMaxSegments ||
      !pair.segments.emplace(segment, std::move(mapping)).second) {
    Distrust(pair, "it passes a segment on twice, or too many");
  }
}

// What comes before its message takes our memory: never more than the credit that the messages need.
void ShmCore::OnPayload(Pair& pair, wire::PayloadApart& payload) {
  const std::scoped_lock lock(pair.in_mutex);
  const auto found = pair.in_links.find(payload.link());
  if (found == pair.in_links.end()) return;
  InLink& link = *found->second;
  const std::uint64_t ahead = payload.number() - link.receipt->received();  // Wraps around for what is past.
  if (ahead == 0 || ahead > link.asked_messages || link.apart_bytes >= link.asked_bytes ||
      pair.apart.contains({payload.link(), payload.number()})) {
    Distrust(pair, "it sends payloads that no message is to have");
    return;
  }
  link.apart_bytes += payload.data().size();
  pair.apart.emplace(std::pair(payload.link(), payload.number()), std::move(*payload.mutable_data()));
}

// Each is a fault of its own, and said for all that are told of at once.
void ShmCore::OnTooLarge(Pair& pair, const wire::TooLarge& said) {
  std::shared_ptr<InLink> link;
  {
    const std::scoped_lock lock(pair.in_mutex);
    const auto found = pair.in_links.find(said.link());
    if (found == pair.in_links.end() || said.messages() <= found->second->too_large) return;
    link = found->second;
  }
  const std::uint64_t more = said.messages() - std::exchange(link->too_large, said.messages());
  faults_[static_cast<std::size_t>(PacketFault::kOverrun)].fetch_add(more, std::memory_order_relaxed);
  link->core->TellFault(PacketFault::kOverrun, "it has " + std::to_string(said.bytes()) + " bytes, and " + Who(pair) +
                                                   " may send at most " + std::to_string(options_.max_message_bytes));
}

void ShmCore::TellMismatch(Pair& pair, const std::string& channel, const std::string& what) {
  if (pair.told_mismatch.size() >= kMaxTold || !pair.told_mismatch.insert(channel).second) return;
  listener_.OnTypeMismatch(channel, pair.facts.info, what);
}

}  // namespace hgros::shm
