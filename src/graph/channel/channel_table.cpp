#include "graph/channel/channel_table.hpp"

#include <utility>

namespace hgros {
namespace {

constexpr std::size_t kFirstBuckets = 64;  // A power of two, like all later counts.

std::size_t HashOf(std::string_view name) noexcept { return std::hash<std::string_view>{}(name); }

}  // namespace

ChannelTable::ChannelTable() {
  generations_.push_back(std::make_unique<Buckets>(kFirstBuckets));
  buckets_.store(generations_.back().get(), std::memory_order_release);
}

Channel* ChannelTable::FindIn(const Buckets& buckets, std::size_t hash, std::string_view name) noexcept {
  const std::size_t index = hash & (buckets.heads.size() - 1);
  for (const Entry* entry = buckets.heads[index].load(std::memory_order_acquire); entry; entry = entry->next) {
    if (entry->hash == hash && entry->channel->name() == name) return entry->channel;
  }
  return nullptr;
}

Channel* ChannelTable::Find(std::string_view name) const noexcept {
  return FindIn(*buckets_.load(std::memory_order_acquire), HashOf(name), name);
}

void ChannelTable::Insert(Buckets& buckets, std::size_t hash, Channel& channel) {
  std::atomic<Entry*>& head = buckets.heads[hash & (buckets.heads.size() - 1)];
  entries_.push_back(std::make_unique<Entry>(Entry{hash, &channel, head.load(std::memory_order_relaxed)}));
  head.store(entries_.back().get(), std::memory_order_release);
}

Channel& ChannelTable::FindOrAdd(std::string_view name, const std::function<std::unique_ptr<Channel>()>& make) {
  const std::scoped_lock lock(mutex_);
  if (Channel* found = Find(name)) return *found;
  channels_.push_back(make());
  Channel& channel = *channels_.back();
  if (channels_.size() > generations_.back()->heads.size()) {
    generations_.push_back(std::make_unique<Buckets>(generations_.back()->heads.size() * 2));
    for (const std::unique_ptr<Channel>& old : channels_) Insert(*generations_.back(), HashOf(old->name()), *old);
    buckets_.store(generations_.back().get(), std::memory_order_release);
  } else {
    Insert(*generations_.back(), HashOf(name), channel);
  }
  return channel;
}

std::vector<Channel*> ChannelTable::All() const {
  const std::scoped_lock lock(mutex_);
  std::vector<Channel*> all;
  for (const std::unique_ptr<Channel>& channel : channels_) all.push_back(channel.get());
  return all;
}

}  // namespace hgros
