#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "graph/channel_table.hpp"
#include "graph/hang_watch.hpp"
#include "graph/tbb_executor.hpp"
#include "graph/untaken_names.hpp"
#include "hgros/base/fork_guard.hpp"
#include "hgros/base/log.hpp"
#include "hgros/graph/data_graph.hpp"

namespace hgros {

// What a DataGraph owns. Handles that outlive the graph keep it, refusing, until they go.
//
// Thread safety: all public functions from any thread.
class GraphCore {
 public:
  GraphCore(GraphOptions options, std::shared_ptr<Log> log);

  Channel& Open(std::string_view name, const TypeInfo& type, const CallSite& where);
  std::shared_ptr<Node> Subscribe(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                                  NodeOptions options);
  void SetClosed(std::string_view name, bool closed);
  bool WaitIdle(std::chrono::steady_clock::time_point deadline) const;
  // The first call also begins to watch: what still runs after 2 s is named in the log, until Shutdown() is done.
  void Refuse() noexcept;
  void Shutdown() noexcept;

  void PublisherIsGone(std::uint64_t publisher);
  void PublisherIsBack(std::uint64_t publisher);
  // Says once in the log which node names of the configuration nobody has taken.
  void SayUntakenNames();
  // Takes a closed node over whose callbacks nobody has waited for.
  void Linger(std::shared_ptr<Node> node);

  [[nodiscard]] bool refusing() const noexcept { return refusing_.load(std::memory_order_relaxed) || fork_.IsChild(); }
  // Nothing of the graph may be waited for or destroyed here.
  [[nodiscard]] bool in_forked_child() const noexcept { return fork_.IsChild(); }
  [[nodiscard]] const MessageId& publisher() const noexcept { return options_.publisher; }
  [[nodiscard]] const Channel* Find(std::string_view name) const noexcept { return channels_.Find(name); }
  [[nodiscard]] std::vector<Channel*> Channels() const { return channels_.All(); }

 private:
  TbbExecutor& Workers();
  [[nodiscard]] std::vector<std::shared_ptr<Node>> Lingering() const;
  void PruneLingering();
  void NameBusyNodes() const;

  const GraphOptions options_;
  const std::shared_ptr<Log> log_;
  std::atomic<bool> refusing_{false};
  const ForkGuard fork_;
  // Before the channels: nodes give their flow-graph nodes back when they go.
  std::mutex workers_mutex_;
  std::optional<TbbExecutor> workers_;
  ChannelTable channels_;
  mutable std::mutex mutex_;
  std::set<std::string, std::less<>> closed_before_open_;
  std::vector<std::shared_ptr<Node>> lingering_;
  UntakenNames untaken_names_;
  std::unique_ptr<HangWatch> hang_watch_;  // Last: its thread reads the others.
};

}  // namespace hgros
