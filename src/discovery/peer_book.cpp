#include "discovery/peer_book.hpp"

#include <utility>

namespace hgros::discovery {

void PeerBook::Put(Announcement peer) {
  const std::scoped_lock lock(mutex_);
  const auto entry = peers_.find(peer.session.value);
  if (entry == peers_.end()) {
    news_.push_back({Event::kCame, peer, {}});
    peers_.emplace(peer.session.value, std::move(peer));
    return;
  }
  if (entry->second == peer) return;
  const bool reborn = entry->second.incarnation != peer.incarnation;
  if (reborn) news_.push_back({Event::kGone, std::move(entry->second), "It restarted."});
  news_.push_back({reborn ? Event::kCame : Event::kChanged, peer, {}});
  entry->second = std::move(peer);
}

void PeerBook::Remove(SessionId session, std::string_view reason) {
  const std::scoped_lock lock(mutex_);
  auto entry = peers_.extract(session.value);
  if (!entry.empty()) news_.push_back({Event::kGone, std::move(entry.mapped()), std::string(reason)});
}

std::vector<Announcement> PeerBook::List(const Discovery::Which& which) const {
  const std::scoped_lock lock(mutex_);
  std::vector<Announcement> listed;
  for (const auto& [session, peer] : peers_) {
    if (!which || which(peer)) listed.push_back(peer);
  }
  return listed;
}

std::vector<SessionId> PeerBook::Sessions() const {
  const std::scoped_lock lock(mutex_);
  std::vector<SessionId> all;
  all.reserve(peers_.size());
  for (const auto& [session, peer] : peers_) all.push_back(peer.session);
  return all;
}

std::size_t PeerBook::size() const {
  const std::scoped_lock lock(mutex_);
  return peers_.size();
}

void PeerBook::Tell(DiscoveryListener& listener) {
  std::deque<News> news;
  {
    const std::scoped_lock lock(mutex_);
    news.swap(news_);
  }
  for (const News& one : news) {
    switch (one.event) {
      case Event::kCame: listener.OnCame(one.peer); break;
      case Event::kChanged: listener.OnChanged(one.peer); break;
      case Event::kGone: listener.OnGone(one.peer, one.reason); break;
    }
  }
}

}  // namespace hgros::discovery
