#include "hgros/c/observe.h"

#include <hgros/Snapshot.pb.h>

#include "c/handles.hpp"
#include "c/raw.hpp"
#include "c/watch.hpp"
#include "hgros/codec/message.hpp"
#include "hgros/session/snapshot_message.hpp"

struct hgros_peers {
  std::vector<hgros::PeerInfo> list;
};

struct hgros_channels {
  std::vector<hgros::KnownChannel> list;
};

namespace hgros::c {
namespace {

hgros_peer PeerOf(const PeerInfo& peer) {
  return {sizeof(hgros_peer), peer.id.value,          peer.process.c_str(), peer.host.c_str(),
          peer.pid,           peer.transport.c_str(), peer.why.c_str()};
}

hgros_status NotFound(const char* what, std::size_t index, std::size_t count) {
  return Fail(HGROS_NOT_FOUND, std::string(what) + " " + std::to_string(index) + " does not exist: there are " +
                                   std::to_string(count) + ".");
}

template <class List, class Out, class F>
hgros_status GetOf(const List& list, const char* what, std::size_t index, Out* out, F&& make) {
  if (index >= list.size()) return NotFound(what, index, list.size());
  FillIn(out, make(list[index]));
  return HGROS_OK;
}

int32_t EventOf(PeerEvent::Kind kind) noexcept {
  switch (kind) {
    case PeerEvent::Kind::kCame: return HGROS_PEER_CAME;
    case PeerEvent::Kind::kGone: return HGROS_PEER_GONE;
    case PeerEvent::Kind::kTypeMismatch: return HGROS_PEER_TYPE_MISMATCH;
    case PeerEvent::Kind::kServedTwice: return HGROS_PEER_SERVED_TWICE;
  }
  return HGROS_PEER_CAME;
}

}  // namespace
}  // namespace hgros::c

namespace c = hgros::c;

hgros_status hgros_peers_open(const hgros_session* session, hgros_peers** peers) {
  return c::Creating(peers,
                     [&] { return std::make_unique<hgros_peers>(hgros_peers{c::Opened(session).session->Peers()}); });
}

size_t hgros_peers_count(const hgros_peers* peers) { return peers == nullptr ? 0 : peers->list.size(); }

hgros_status hgros_peers_get(const hgros_peers* peers, size_t index, hgros_peer* peer) {
  return c::Guarded([&] { return c::GetOf(c::Given(peers, "peers").list, "Peer", index, peer, c::PeerOf); });
}

void hgros_peers_free(hgros_peers* peers) { delete peers; }

hgros_status hgros_channels_open(hgros_session* session, hgros_channels** channels) {
  return c::Creating(channels, [&] {
    return std::make_unique<hgros_channels>(hgros_channels{c::Opened(session).session->Channels()});
  });
}

size_t hgros_channels_count(const hgros_channels* channels) { return channels == nullptr ? 0 : channels->list.size(); }

hgros_status hgros_channels_get(const hgros_channels* channels, size_t index, hgros_channel* channel) {
  return c::Guarded([&] {
    return c::GetOf(c::Given(channels, "channels").list, "Channel", index, channel, [](const hgros::KnownChannel& of) {
      return hgros_channel{sizeof(hgros_channel),
                           of.name.c_str(),
                           of.type_name.c_str(),
                           of.fingerprint,
                           static_cast<int32_t>(of.encoding),
                           of.publishers.size(),
                           of.subscribers.size()};
    });
  });
}

hgros_status hgros_channels_get_user(const hgros_channels* channels, size_t index, int32_t role, size_t user_index,
                                     hgros_channel_user* user) {
  return c::Guarded([&] {
    const auto& list = c::Given(channels, "channels").list;
    if (index >= list.size()) return c::NotFound("Channel", index, list.size());
    if (role != HGROS_ROLE_PUBLISHER && role != HGROS_ROLE_SUBSCRIBER) {
      throw c::InvalidArgument("There is no role " + std::to_string(role) + ". Use HGROS_ROLE_...");
    }
    const auto& users = role == HGROS_ROLE_PUBLISHER ? list[index].publishers : list[index].subscribers;
    return c::GetOf(users, "User", user_index, user, [](const hgros::ChannelUser& of) {
      return hgros_channel_user{sizeof(hgros_channel_user), of.lossless ? 1 : 0, of.session.value,
                                of.process.c_str(),         of.host.c_str(),     of.pid,
                                of.type_name.c_str()};
    });
  });
}

void hgros_channels_free(hgros_channels* channels) { delete channels; }

hgros_status hgros_session_snapshot(const hgros_session* session, hgros_message** snapshot) {
  return c::Creating(snapshot, [&] {
    static const auto& schema = *new auto(  // Messages may outlive the program's static objects.
        std::make_shared<const hgros::MessageSchema>(hgros::SchemaOf(hgros::TypeOf<hgros::Snapshot>())));
    const hgros::Snapshot now = ToMessage(c::Opened(session).session->Snapshot());
    auto text = std::make_shared<const std::string>(now.SerializeAsString());
    const hgros::Bytes bytes = hgros::AsBytes(*text);
    return c::NewLease(
        std::make_shared<const hgros::RawMessage>(hgros::RawMessage{schema, hgros::Payload{bytes, std::move(text)}}));
  });
}

void hgros_watch_close(hgros_watch* watch) {
  const c::InClose closes;
  delete watch;
}

hgros_status hgros_watch_peers(hgros_session* session, hgros_peer_callback callback, void* user, hgros_release release,
                               hgros_watch** watch) {
  return c::CreatingFor(
      c::CallbackOf{c::LifeOf(session), {}}, user, release, watch, [&](const std::shared_ptr<const c::User>& kept) {
        const hgros_session& on = c::Opened(session);
        if (callback == nullptr) c::RefuseNull("callback");
        auto made = std::make_unique<hgros_watch>();
        made->watching.subscription = on.session->FromGraph<hgros::PeerEvent>(
            hgros::kPeerEventsChannel, hgros::Invoke::kSerial,
            [callback, kept, life = on.life, calls = made->calls](const hgros::PeerEvent& event) {
              const c::InCallback inside(life.get());
              calls->Run([&] {
                const hgros_peer peer = c::PeerOf(event.peer);
                callback(kept->get(), c::EventOf(event.kind), &peer, event.channel.c_str(), event.reason.c_str());
              });
            },
            {{}, hgros::Queue::KeepLast(1024), {}}, c::kFromC);
        return made;
      });
}
