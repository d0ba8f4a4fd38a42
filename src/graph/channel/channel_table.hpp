#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string_view>
#include <vector>

#include "graph/channel/channel.hpp"

namespace hgros {

// Channels by name. A lookup takes no lock and writes nothing, even while channels are added.
//
// Thread safety: all functions from any thread.
// Invariants: channels are only added. A larger bucket array replaces a full one, which is kept until the table is
// destroyed. A reader of the old one may miss a new channel and then asks again under the lock.
class ChannelTable {
 public:
  ChannelTable();

  // Null if there is no such channel.
  [[nodiscard]] Channel* Find(std::string_view name) const noexcept;
  // The channel of that name; `make` creates it if it does not exist.
  Channel& FindOrAdd(std::string_view name, const std::function<std::unique_ptr<Channel>()>& make);
  [[nodiscard]] std::vector<Channel*> All() const;

 private:
  struct Entry {
    std::size_t hash;
    Channel* channel;
    Entry* next;
  };
  struct Buckets {
    explicit Buckets(std::size_t count) : heads(count) {}
    std::vector<std::atomic<Entry*>> heads;
  };

  [[nodiscard]] static Channel* FindIn(const Buckets& buckets, std::size_t hash, std::string_view name) noexcept;
  void Insert(Buckets& buckets, std::size_t hash, Channel& channel);

  std::atomic<const Buckets*> buckets_;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Channel>> channels_;
  std::vector<std::unique_ptr<Entry>> entries_;
  std::vector<std::unique_ptr<Buckets>> generations_;
};

}  // namespace hgros
