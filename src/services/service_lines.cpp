// The lines on which a service replies to other sessions.
#include <algorithm>
#include <utility>

#include "services/service_host.hpp"

namespace hgros {

std::shared_ptr<ReplyLine> ServiceHost::LineTo(SessionId caller) const {
  const std::scoped_lock lock(mutex_);
  const auto found = lines_.find(caller.value);
  return found == lines_.end() ? nullptr : found->second;
}

std::shared_ptr<ReplyLine> ServiceHost::OpenLine(SessionId caller) {
  if (auto line = LineTo(caller)) return line;
  const auto services = services_.lock();
  if (!services || ended()) return nullptr;
  std::shared_ptr<ReplyLine> line;
  const ReplyLine::Means means = MeansOf(caller);
  services->With([&](ServicePlace& place) {
    const std::string channel = ReplyChannel(setting_.name, caller);
    const auto outlet =
        place.OpenOutlet(channel, *setting_.reply, {means.flush_soon, means.flush_soon, [] { return true; }});
    const std::vector<PeerInfo> peers = place.Peers();
    const auto peer = std::ranges::find(peers, caller, &PeerInfo::id);
    auto made = std::make_shared<ReplyLine>(outlet, *setting_.reply, log_, setting_.name,
                                            peer == peers.end() ? caller.ToString() : peer->name(), room_, means);
    {
      const std::scoped_lock lock(mutex_);
      // A caller that has left meanwhile gets no line. A caller that leaves later is found in lines_ by OnPeerGone().
      const bool here = std::ranges::any_of(place.Peers(), [&](const PeerInfo& one) { return one.id == caller; });
      if (!ended_ && here) line = lines_.emplace(caller.value, made).first->second;
    }
    if (line != made) place.CloseOutlet(channel, outlet);
  });
  return line;
}

ReplyLine::Means ServiceHost::MeansOf(SessionId caller) {
  const auto flush = [self = weak_from_this(), caller] {
    if (const auto host = self.lock()) host->Flush(caller);
  };
  ReplyLine::Means means;
  means.flush_soon = [weak = services_, flush] {
    if (const auto services = weak.lock()) services->Post(flush);
  };
  means.flush_at = [weak = services_, flush](ReplyLine::Moment when) {
    if (const auto services = weak.lock()) services->PostAt(when, flush);
  };
  means.why = [weak = services_, service = setting_.name](bool subscribed) -> std::string {
    if (subscribed) return "That session does not take its replies fast enough.";
    ReplyWays ways;
    if (const auto services = weak.lock()) {
      services->With([&](ServicePlace& place) { ways = place.WaysOf(service); });
    }
    const std::string channel = RequestChannel(service);
    if (!ways.leave) {
      return "Replies cannot leave this session: no publisher endpoint has \"" + channel +
             "\" in its list of channels. Add it.";
    }
    return "That session does not subscribe to its replies: a subscriber endpoint there must reach this session, and "
           "if it has a list of channels, \"" +
           channel + "\" must be in it.";
  };
  return means;
}

void ServiceHost::Flush(SessionId caller) {
  if (const auto line = LineTo(caller)) dropped_replies_ += line->Flush();
}

}  // namespace hgros
