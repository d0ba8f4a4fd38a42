#include "transport/shm/shm_receiver.hpp"

#include <algorithm>
#include <utility>

namespace hgros::shm {
namespace {

constexpr int kMessagesPerTurn = 64;  // From one peer, before others have their turn.

}  // namespace

ShmReceiver::ShmReceiver(ShmSession& session, PairTable& pairs, SocketThread& sockets, ShmPublisher& publisher,
                         WantedChannels& wanted)
    : session_(session),
      pairs_(pairs),
      sockets_(sockets),
      publisher_(publisher),
      wanted_(wanted),
      bell_(Patience{
          .busy = session.options.wait == ShmWait::kBusy,
          .spin = session.options.wait == ShmWait::kSpin ? session.options.spin : std::chrono::microseconds(0)}) {}

void ShmReceiver::Wait() noexcept { bell_.Wait(); }

void ShmReceiver::Wake() noexcept { bell_.Wake(); }

LeaderPool::Task ShmReceiver::Lead() noexcept {
  for (;;) {
    if (!bell_.CollectRings([this](std::uint32_t number) { to_read_.push_back(number); })) return {};
    // Start after the pair that was read last, so that a busy pair does not block the others.
    std::rotate(to_read_.begin(), std::ranges::upper_bound(to_read_, last_read_), to_read_.end());
    for (std::size_t i = 0; i < to_read_.size(); ++i) {
      const std::uint32_t number = last_read_ = to_read_[i];
      const auto pair = pairs_.At(number);
      if (!pair) continue;
      if (pair->hungry.load()) publisher_.SendWaiting(*pair);
      auto task = ReadFrom(pair);
      if (!task) continue;
      // Another thread reads the rest.
      for (++i; i < to_read_.size(); ++i) bell_.Ring(to_read_[i]);
      to_read_.clear();
      bell_.PassOn();
      return task;
    }
    to_read_.clear();
    if (Transport::IsVisitor()) return {};  // A visitor returns at once. Pairs with more to read have rung again.
  }
}

LeaderPool::Task ShmReceiver::ReadFrom(const std::shared_ptr<Pair>& pair) {
  using Step = PairInbox::Step;
  for (int i = 0; i < kMessagesPerTurn; ++i) {
    PairInbox::Arrival arrival;
    Step step = pair->in.Next(arrival, session_.options.max_message_bytes);
    if (step == Step::kLie && pair->ending.load()) step = Step::kNothing;  // It has ended for another reason.
    if (arrival.ends) {
      sockets_.PostFor(*pair,
                       [this, number = arrival.link->link](const auto& same) { wanted_.EndLink(*same, number); });
    }
    switch (step) {
      case Step::kSkipped: continue;
      case Step::kNotYet: return {};
      case Step::kLie: sockets_.Distrust(*pair, arrival.lie); return {};
      case Step::kNothing:
        if (pair->ending.load() && pair->in.MarkAllRead()) sockets_.FinishPair(pair);
        return {};
      case Step::kLost:
        session_.CountFault(PacketFault::kOverrun);
        arrival.link->core->TellFault(PacketFault::kOverrun, "it came over a socket, and there is no memory for it");
        continue;
      case Step::kMessage: break;
    }
    const auto& link = arrival.link;
    const InboundMessage& message = arrival.message;
    // The link's type is checked once.
    if (!link->checked || message.head.id.publisher != message.from.value) {
      if (const auto wrong = link->core->Check(message.head, message.from, message.head.fingerprint);
          wrong.fault != PacketFault::kNone) {
        session_.CountFault(wrong.fault);
        link->core->TellFault(wrong.fault, wrong.what);
        continue;
      }
      link->checked = true;
    }
    auto task = InboundCore::Deliver(link->core, std::move(arrival.message), session_.repeats);
    if (!task) continue;
    if (pair->ending.load() || pair->in.HasMore()) bell_.Ring(pair->number);
    return task;
  }
  bell_.Ring(pair->number);
  return {};
}

}  // namespace hgros::shm
