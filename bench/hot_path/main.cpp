// Sends messages in all the usual ways and measures nothing. callgrind counts which functions they pass through.
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "foxglove/PointCloud.pb.h"
#include "hgros/hgros.hpp"

namespace {

using hgros::Block;
using hgros::Config;
using hgros::Executor;
using hgros::Invoke;
using hgros::Queue;
using hgros::Session;

constexpr int kMessages = 200;
constexpr std::size_t kBytes = 1024;

struct Plain {
  std::array<std::int64_t, 16> values{};
};

std::unique_ptr<Block> MakeBlock() {
  auto block = std::make_unique<Block>(Block::Allocate(kBytes));
  std::memset(block->writable().data(), 1, block->size());
  return block;
}

std::unique_ptr<foxglove::PointCloud> MakeCloud() {
  auto cloud = std::make_unique<foxglove::PointCloud>();
  cloud->set_frame_id("laser");
  cloud->set_data(std::string(kBytes, 'x'));
  return cloud;
}

std::unique_ptr<Plain> MakePlain() { return std::make_unique<Plain>(); }

/// Sends one message after another. Each is sent when the one before has arrived.
template <class T>
bool Send(Session& from, Session& to, const std::string& channel, Executor executor, bool lossless,
          std::unique_ptr<T> (*make)()) {
  std::atomic<int> arrived{0};
  const auto subscription =
      to.FromAny<T>(channel, Invoke::kSerial,
                    [&arrived](const T&) {
                      arrived.fetch_add(1);
                      arrived.notify_all();
                    },
                    {.queue = lossless ? Queue::KeepAll(64) : Queue::KeepLast(16), .executor = std::move(executor)});
  const auto publisher = from.Advertise<T>(channel);
  if (!from.WaitForSubscribers(channel, 1, std::chrono::seconds(20))) return false;
  for (int i = 0; i < kMessages; ++i) {
    if (publisher(make()) != hgros::PublishStatus::kOk) return false;
    while (arrived.load() <= i) arrived.wait(i);
  }
  return true;
}

/// As Send(), for programs that know the type at run time only, such as those in other languages. There the thread that
/// waits for messages receives them itself.
bool SendRaw(Session& from, Session& to, const std::string& channel) {
  std::atomic<int> arrived{0};
  const auto subscription = to.FromAnyRaw(
      channel, Invoke::kSerial,
      [&arrived](const std::shared_ptr<const hgros::RawMessage>&, const hgros::MessageInfo&) { arrived.fetch_add(1); },
      {.executor = Executor::Inline()});
  const auto publisher = from.AdvertiseRaw(channel, hgros::SchemaOf(hgros::TypeOf<foxglove::PointCloud>()));
  if (!from.WaitForSubscribers(channel, 1, std::chrono::seconds(20))) return false;
  const std::jthread sender([&](const std::stop_token& stop) {
    const std::string wire = MakeCloud()->SerializeAsString();
    for (int i = 0; i < kMessages && !stop.stop_requested(); ++i) {
      if (publisher({hgros::AsBytes(wire), nullptr}) != hgros::PublishStatus::kOk) return;
      while (arrived.load() <= i && !stop.stop_requested()) std::this_thread::yield();
    }
  });
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  for (int seen = 0; seen < kMessages; seen = arrived.load()) {
    const auto more = [&] { return arrived.load() > seen; };
    if (!to.ReceiveHere(more, deadline)) std::this_thread::yield();  // Another thread receives.
    if (std::chrono::steady_clock::now() > deadline) return false;
  }
  return true;
}

bool SendAll(Session& from, Session& to, const std::string& name) {
  return Send<Block>(from, to, name + "_block", Executor::Inline(), false, MakeBlock) &&
         Send<Block>(from, to, name + "_lossless", Executor::Inline(), true, MakeBlock) &&
         Send<Plain>(from, to, name + "_plain", Executor::Inline(), false, MakePlain) &&
         Send<foxglove::PointCloud>(from, to, name + "_cloud", Executor::Inline(), false, MakeCloud) &&
         Send<foxglove::PointCloud>(from, to, name + "_cloud_tbb", Executor::Tbb(), false, MakeCloud);
}

/// Makes one call after another from a thread that waits for the reply.
bool CallAll(Session& from, Session& to, const std::string& name) {
  const auto service = to.Serve<Plain, Plain>(name, [](const Plain& request) { return request; }, Invoke::kConcurrent,
                                              {.executor = Executor::Inline()});
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  for (int i = 0; i < kMessages;) {
    const auto reply = from.Call<Plain, Plain>(name, MakePlain(), std::chrono::seconds(20)).Wait();
    if (reply) {
      ++i;
    } else if (i > 0 || std::chrono::steady_clock::now() > deadline) {  // The first call may come before discovery.
      std::fprintf(stderr, "Call %d: %s\n", i, reply.failure().reason.c_str());
      return false;
    }
  }
  return true;
}

int Run() {
  Config here;
  here.discovery.domain = "hot-path-" + std::to_string(getpid());
  Session a(here, {"a", nullptr}), b(here, {"b", nullptr});
  Config alone;
  alone.discovery.local = false;
  Session c(alone, {"c", nullptr}), d(alone, {"d", nullptr});
  c.AddPublisherEndpoint({.endpoint = "ipc:///tmp/hgros_bench_hot_path_" + std::to_string(getpid()),
                          .channels = {},
                          .all_channels = true});
  for (const std::string& endpoint : c.PublisherEndpoints())
    d.AddSubscriberEndpoint({.endpoint = endpoint, .channels = {}, .all_channels = true});
  if (SendAll(a, a, "graph") && SendAll(a, b, "shm") && SendRaw(a, b, "shm_raw") && SendAll(c, d, "ipc") &&
      CallAll(a, b, "echo"))
    return 0;
  std::fputs("The sessions did not find each other, or a message or a call was refused.\n", stderr);
  return 1;
}

}  // namespace

int main() try { return Run(); } catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
