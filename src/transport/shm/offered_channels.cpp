#include "transport/shm/offered_channels.hpp"

#include <algorithm>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/base/readable_text.hpp"

namespace hgros::shm {
namespace {

static_assert(kMaxChannels == kCells);

wire::PairMessage GrantedFrame(const OutChannel& core, const wire::Wish& asked, const Demand& granted) {
  wire::PairMessage said;
  auto& answer = *said.mutable_granted();
  answer.set_link(asked.link());
  WriteType(core.name, core.type, *answer.mutable_offered());
  answer.set_credit_messages(granted.credit_messages);
  answer.set_credit_bytes(granted.credit_bytes);
  return said;
}

}  // namespace

Demand OfferedChannels::GrantedTo(const OutboundCore& core, const wire::Wish& asked) const {
  return PeerChannel::Granted({.lossless = asked.lossless() && core.may_promise,
                               .queue_depth = asked.queue_depth(),
                               .credit_messages = asked.credit_messages(),
                               .credit_bytes = asked.credit_bytes()},
                              session_.options.max_credit_bytes);
}

void OfferedChannels::Offer(const std::shared_ptr<OutChannel>& core) {
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    if (!channels_.emplace(core->name, core).second) {
      throw Error("Channel " + core->name + " is already advertised here.", {},
                  "Share the first object, or destroy it first.");
    }
    for (const auto& pair : pairs_.List()) {
      const auto wish = pair->wishes.find(core->name);
      if (pair->alive && wish != pair->wishes.end() && !wish->second.linked) Serve(*pair, wish->second, actions);
    }
  }
  sockets_.Post(std::move(actions));
}

void OfferedChannels::Withdraw(const std::shared_ptr<OutChannel>& core) {
  Actions nobody_listens;
  {
    const std::scoped_lock lock(mutex_);
    const auto found = channels_.find(core->name);
    if (found != channels_.end() && found->second == core) {
      for (const auto& pair : pairs_.List()) {
        const auto wish = pair->wishes.find(core->name);
        if (wish == pair->wishes.end() || !wish->second.linked) continue;
        publisher_.WithdrawLink(*core, *pair, nobody_listens);
        pair->ended[core->name] = wish->second.asked.link();
        pair->wishes.erase(wish);  // The peer asks again.
      }
      channels_.erase(found);
    }
  }
  core->gate.Close();
}

void OfferedChannels::OnWish(Pair& pair, const wire::Wish& asked) {
  const std::string& name = asked.wanted().channel();
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    if (!pair.alive) return;
    if (!ChannelNameFault(name).empty() || asked.wanted().type_name().size() > kMaxTypeNameBytes ||
        asked.cell() >= kCells || (pair.wishes.size() >= kMaxChannels && !pair.wishes.contains(name))) {
      sockets_.Distrust(pair, "it sends an invalid wish");
      return;
    }
    // The peer does not know yet that the link has ended.
    if (const auto ended = pair.ended.find(name); ended != pair.ended.end()) {
      if (ended->second == asked.link()) return;
      pair.ended.erase(ended);
    }
    PeerWish& wish = pair.wishes[name];
    const bool change = wish.linked && wish.asked.link() == asked.link();
    wish.asked = asked;
    if (change) {
      const Demand granted = GrantedTo(*wish.linked, asked);
      publisher_.ChangeDemand(*wish.linked, pair, granted, GrantedFrame(*wish.linked, asked, granted), actions);
    } else {
      EndLink(pair, wish, ShmPublisher::LinkEnd::kForGood, actions);
      Serve(pair, wish, actions);
    }
  }
  for (const auto& action : actions) action();
}

void OfferedChannels::Serve(Pair& pair, PeerWish& wish, Actions& actions) {
  const auto& wanted = wish.asked.wanted();
  const auto found = channels_.find(wanted.channel());
  if (found == channels_.end()) return;  // Served when it is offered.
  const auto& core = found->second;
  const auto descriptor_set = SchemaFor(wanted, core->type);
  if (!descriptor_set) {
    const std::string what = DescribeMismatch(wanted, pair.facts.info, core->type, session_.self.info, false);
    wire::PairMessage said;
    said.mutable_misfit()->set_link(wish.asked.link());
    WriteType(core->name, core->type, *said.mutable_misfit()->mutable_offered());
    said.mutable_misfit()->set_reason(what);
    pair.socket.Send(said);
    actions.emplace_back([this, to = pair.shared_from_this(), channel = core->name, what] {
      ReportMismatch(session_.listener, *to, channel, what);
    });
    return;
  }
  const Demand granted = GrantedTo(*core, wish.asked);
  publisher_.AddLink(core, pair, wish.asked, granted, actions);
  wish.linked = core;
  wire::PairMessage said = GrantedFrame(*core, wish.asked, granted);
  said.mutable_granted()->set_descriptor_set(*descriptor_set);
  pair.socket.Send(said);
  actions.emplace_back([this, core, to = pair.shared_from_this(), number = wish.asked.link()] {
    publisher_.BeginLink(core, *to, number);
  });
}

void OfferedChannels::EndLink(Pair& pair, PeerWish& wish, ShmPublisher::LinkEnd why, Actions& actions) {
  if (const auto core = std::exchange(wish.linked, nullptr)) publisher_.RemoveLink(*core, pair, why, actions);
}

void OfferedChannels::OnUnwish(Pair& pair, const wire::Unwish& unwish) {
  Actions actions;
  {
    const std::scoped_lock lock(mutex_);
    const auto wish = std::ranges::find_if(
        pair.wishes, [&](const auto& entry) { return entry.second.asked.link() == unwish.link(); });
    if (wish == pair.wishes.end()) return;
    const std::string channel = wish->first;
    const bool linked = wish->second.linked != nullptr;
    EndLink(pair, wish->second, ShmPublisher::LinkEnd::kAsked, actions);
    pair.wishes.erase(wish);
    if (linked && !unwish.mismatch().empty()) {
      actions.emplace_back([this, &pair, channel, what = Readable(unwish.mismatch(), kMaxTextBytes)] {
        ReportMismatch(session_.listener, pair, channel, what);
      });
    }
  }
  for (const auto& action : actions) action();
}

void OfferedChannels::EndPair(Pair& pair, ShmPublisher::LinkEnd why, Actions& actions) {
  const std::scoped_lock lock(mutex_);
  publisher_.RemoveAllLinks(pair, why, actions);
  pair.wishes.clear();
}

}  // namespace hgros::shm
