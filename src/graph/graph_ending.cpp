#include "hgros/graph/graph_ending.hpp"

#include <algorithm>
#include <condition_variable>
#include <system_error>
#include <thread>
#include <utility>

#include "graph/graph_core.hpp"
#include "graph/nodes/callback_scope.hpp"

namespace hgros {
namespace {

constexpr auto kTimeForOthers = std::chrono::milliseconds(500);
constexpr auto kTimeInAll = std::chrono::milliseconds(1500);

// What one thread waits for and another thread reports.
struct Report {
  std::mutex mutex;
  std::condition_variable changed;
  bool done = false;
};

}  // namespace

void GraphEnding::SetOnExit(std::function<void()> on_exit) { graph_.core_->SetOnExit(std::move(on_exit)); }
std::string GraphEnding::CallbackHere() const { return graph_.core_->CallbackHere(); }
void GraphEnding::End(std::function<void()> leave) noexcept { graph_.core_->EndInside(std::move(leave)); }
bool GraphEnding::ended() const noexcept { return graph_.core_->ended_inside(); }

void GraphCore::SetOnExit(std::function<void()> on_exit) {
  const std::scoped_lock lock(mutex_);
  on_exit_ = std::move(on_exit);
}

void GraphCore::OnExitInside() noexcept {
  if (in_forked_child()) return;
  std::function<void()> on_exit;
  {
    const std::scoped_lock lock(mutex_);
    on_exit = on_exit_;
  }
  on_exit ? on_exit() : EndInside({});
}

std::string GraphCore::CallbackHere() const {
  const Node* const node = CallbackScope::NodeOf(this);
  return node == nullptr ? std::string()
                         : "node \"" + node->setting().name + "\" on channel \"" + node->setting().channel + "\"";
}

bool GraphCore::EndsInside() noexcept {
  if (ended_inside()) return true;
  const std::string callback = CallbackHere();
  if (callback.empty()) return false;
  log_->Write(LogLevel::kError, "A data graph was destroyed inside the callback of its " + callback +
                                    ". Its threads and memory stay until the process ends. Destroy it on another "
                                    "thread.");
  Refuse();
  EndInside({});
  return true;
}

// On another thread, because it may have to wait for somebody who waits for the callback on this thread.
void GraphCore::EndInside(std::function<void()> leave) noexcept {
  if (in_forked_child() || ended_inside_.exchange(true)) return;
  const auto report = std::make_shared<Report>();
  try {
    std::thread([self = shared_from_this(), report, leave = std::move(leave), own = CallbackScope::Nodes()] {
      const CallbackScope inside(self.get(), nullptr);  // Subscriptions that end here do not wait for callbacks either.
      self->CloseNodes();
      self->WaitForOthers(own, std::chrono::steady_clock::now() + kTimeForOthers);
      if (leave) leave();
      {
        const std::scoped_lock lock(report->mutex);
        report->done = true;
      }
      report->changed.notify_all();
    }).detach();
  } catch (const std::system_error&) {  // No thread is available: then other sessions notice the end by themselves.
    CloseNodes();
    return;
  }
  std::unique_lock lock(report->mutex);
  report->changed.wait_for(lock, kTimeInAll, [&] { return report->done; });
}

void GraphCore::CloseNodes() noexcept {
  for (Channel* channel : channels_.All()) {
    for (const std::shared_ptr<Node>& node : channel->Nodes()) node->Close(false);
  }
}

void GraphCore::WaitForOthers(const std::vector<const Node*>& own,
                              std::chrono::steady_clock::time_point deadline) const {
  std::vector<std::shared_ptr<Node>> nodes = Lingering();
  for (const Channel* channel : channels_.All()) {
    const std::vector<std::shared_ptr<Node>> wired = channel->Nodes();
    nodes.insert(nodes.end(), wired.begin(), wired.end());
  }
  for (const std::shared_ptr<Node>& node : nodes) {
    (void)node->WaitForOthers(static_cast<int>(std::ranges::count(own, node.get())), deadline);
  }
}

}  // namespace hgros
