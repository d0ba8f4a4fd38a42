#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "graph/channel/channel_table.hpp"
#include "graph/hang_watch.hpp"
#include "graph/nodes/tbb_executor.hpp"
#include "graph/unmatched_overrides.hpp"
#include "hgros/base/fork_guard.hpp"
#include "hgros/base/log.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/graph/trace_recorder.hpp"

namespace hgros {

// The state of a DataGraph. Handles that outlive the graph keep it alive; it then refuses everything.
//
// Thread safety: all public functions from any thread.
class GraphCore : public std::enable_shared_from_this<GraphCore> {
 public:
  GraphCore(GraphOptions options, std::shared_ptr<Log> log);

  Channel& Open(std::string_view name, const TypeInfo& type, const CallSite& where);
  std::shared_ptr<Node> Subscribe(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                                  NodeOptions options);
  void SetClosed(std::string_view name, bool closed);
  bool WaitIdle(std::chrono::steady_clock::time_point deadline) const;
  // The first call also starts the HangWatch: nodes that still run after 2 s are named in the log, until Shutdown()
  // ends.
  void Refuse() noexcept;
  void Shutdown() noexcept;

  // In graph_ending.cpp, which GraphEnding and CallbackScope use.
  void SetOnExit(std::function<void()> on_exit);
  void OnExitInside() noexcept;
  void EndInside(std::function<void()> leave) noexcept;
  // True if the graph must be kept: it has ended inside a callback, or the caller runs one and so ends it now.
  [[nodiscard]] bool EndsInside() noexcept;
  [[nodiscard]] std::string CallbackHere() const;
  [[nodiscard]] bool ended_inside() const noexcept { return ended_inside_.load(); }

  void PublisherIsGone(std::uint64_t publisher);
  void PublisherIsBack(std::uint64_t publisher);
  // Logs once which node names of the configuration match no node.
  void LogUnmatchedOverrides();
  // Keeps a closed node whose running callbacks were not waited for.
  void Linger(std::shared_ptr<Node> node);

  [[nodiscard]] bool refusing() const noexcept { return refusing_.load(std::memory_order_relaxed) || fork_.IsChild(); }
  // In a forked child nothing of the graph may be waited for or destroyed.
  [[nodiscard]] bool in_forked_child() const noexcept { return fork_.IsChild(); }
  [[nodiscard]] TraceRecorder& trace() noexcept { return trace_; }
  [[nodiscard]] Log& log() const noexcept { return *log_; }
  [[nodiscard]] const MessageId& publisher() const noexcept { return options_.publisher; }
  [[nodiscard]] Channel* Find(std::string_view name) const noexcept { return channels_.Find(name); }
  [[nodiscard]] std::vector<Channel*> Channels() const { return channels_.All(); }

 private:
  TbbExecutor& Workers();
  [[nodiscard]] std::vector<std::shared_ptr<Node>> Lingering() const;
  void PruneLingering();
  void NameBusyNodes() const;
  void CloseNodes() noexcept;
  void WaitForOthers(const std::vector<const Node*>& own, std::chrono::steady_clock::time_point deadline) const;

  const GraphOptions options_;
  const std::shared_ptr<Log> log_;
  std::atomic<bool> refusing_{false};
  std::atomic<bool> ended_inside_{false};
  TraceRecorder trace_;
  std::function<void()> on_exit_;  // Guarded by mutex_.
  const ForkGuard fork_;
  // Declared before the channels, because nodes return their flow-graph nodes when they are destroyed.
  std::mutex workers_mutex_;
  std::optional<TbbExecutor> workers_;
  ChannelTable channels_;
  mutable std::mutex mutex_;
  std::set<std::string, std::less<>> closed_before_open_;
  std::vector<std::shared_ptr<Node>> lingering_;
  UnmatchedOverrides unmatched_overrides_;
  std::unique_ptr<HangWatch> hang_watch_;  // Last: its thread reads the others.
};

}  // namespace hgros
