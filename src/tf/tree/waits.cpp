#include "tf/tree/waits.hpp"

#include <algorithm>
#include <exception>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "hgros/base/forced_unwind.hpp"
#include "hgros/base/log.hpp"
#include "tf/tree/tree_core.hpp"

namespace hgros::tf {
namespace {

void SayThrown(std::string_view what) {
  Log().Write(LogLevel::kError,
              "A callback that waited for a transform threw: " + std::string(what) + ". It is not called again.");
}

}  // namespace

Waiter::Waiter(const TransformQuery& query, TransformCallback callback)
    : query_(query), callback_(std::move(callback)) {}

void Waiter::Finish(const TransformResult& result) {
  std::unique_lock lock(mutex_);
  if (state_ != State::kPending) return;
  if (callback_) {
    state_ = State::kRunning;
    runs_on_ = std::this_thread::get_id();
    lock.unlock();
    try {
      callback_(result);
    } catch (const std::exception& error) {
      SayThrown(error.what());
    } catch (const ForcedUnwind&) {
      Log log;
      EndAfterForcedUnwind(log, "A callback that waited for a transform");
    } catch (...) {
      SayThrown("something that is not a std::exception");
    }
    lock.lock();
  }
  result_ = result;
  state_ = State::kDone;
  changed_.notify_all();
}

void Waiter::Cancel() {
  std::unique_lock lock(mutex_);
  if (state_ == State::kRunning && runs_on_ != std::this_thread::get_id()) {
    changed_.wait(lock, [this] { return state_ != State::kRunning; });
  }
  if (state_ == State::kPending) state_ = State::kDone;
}

bool Waiter::pending() const {
  const std::scoped_lock lock(mutex_);
  return state_ == State::kPending;
}

std::optional<TransformResult> Waiter::Sleep(std::chrono::steady_clock::time_point deadline, std::stop_token stop) {
  std::unique_lock lock(mutex_);
  const auto done = [this] { return state_ == State::kDone; };
  if (deadline == std::chrono::steady_clock::time_point::max()) {
    changed_.wait(lock, std::move(stop), done);
  } else {
    changed_.wait_until(lock, std::move(stop), deadline, done);
  }
  return result_;
}

void Waits::Add(const std::shared_ptr<Waiter>& waiter) {
  std::optional<TransformResult> result;
  {
    const std::scoped_lock lock(mutex_);
    if (tree_ == nullptr) return;
    if (!Settle(*waiter, result)) pending_.push_back(waiter);
  }
  if (result) waiter->Finish(*result);
}

void Waits::Remove(const std::shared_ptr<Waiter>& waiter) {
  const std::scoped_lock lock(mutex_);
  pending_.remove(waiter);
}

void Waits::EdgeHasGrown(Frame& edge) { LookAgain(&edge); }
void Waits::TreeHasGrown() { LookAgain(nullptr); }
// Waits for other edges are checked too: the stamp that they need there depends on this edge.
void Waits::EdgeHasRestarted() { LookAgain(nullptr, For::kEverybody); }

void Waits::Close() {
  std::list<std::shared_ptr<Waiter>> forgotten;
  const std::scoped_lock lock(mutex_);
  tree_ = nullptr;
  forgotten.swap(pending_);
}

void Waits::LookAgain(Frame* edge, For whom) {
  std::vector<std::pair<std::shared_ptr<Waiter>, TransformResult>> settled;
  {
    const std::scoped_lock lock(mutex_);
    if (tree_ == nullptr) return;
    std::int64_t newest = 0;
    if (edge != nullptr) {
      const std::scoped_lock edge_lock(edge->write);
      newest = edge->newest;
      edge->awaited_from = std::numeric_limits<std::int64_t>::max();
      for (const std::shared_ptr<Waiter>& waiter : pending_) {
        if (waiter->edge_ != edge || waiter->from_stamp_ <= newest) continue;
        edge->awaited_from = std::min(edge->awaited_from, waiter->from_stamp_);
      }
    }
    for (auto place = pending_.begin(); place != pending_.end();) {
      Waiter& waiter = **place;
      std::optional<TransformResult> result;
      const bool concerned =
          whom == For::kEverybody || (waiter.edge_ == edge && (edge == nullptr || waiter.from_stamp_ <= newest));
      if (concerned && Settle(waiter, result)) {
        settled.emplace_back(std::move(*place), std::move(*result));
        place = pending_.erase(place);
      } else {
        ++place;
      }
    }
  }
  for (const auto& [waiter, result] : settled) waiter->Finish(result);
}

// False if the edge has it already.
bool Waits::Await(Waiter& waiter, const Frame& growing, std::int64_t from_stamp) {
  Frame& edge = *tree_->frames_.At(growing.id);
  const std::scoped_lock lock(edge.write);
  if (edge.newest >= from_stamp) return false;
  edge.awaited_from = std::min(edge.awaited_from, from_stamp);
  waiter.edge_ = &edge;
  waiter.from_stamp_ = from_stamp;
  return true;
}

// True with the result. Otherwise false: then the thread that sets the missing thing will check again. The missing
// thing is noted under the lock under which it is set, if it is still missing then.
bool Waits::Settle(Waiter& waiter, std::optional<TransformResult>& result) {
  for (;;) {
    std::uint64_t edges = 0;
    {
      const std::scoped_lock lock(tree_->topology_);
      edges = tree_->edge_count_;
    }
    const std::uint64_t restarted_edges = tree_->restarted_edges_.load(std::memory_order_relaxed);
    Outcome outcome;
    tree_->Lookup(waiter.query_, outcome);
    if (outcome.fault == TransformFault::kTooNew) {
      if (!Await(waiter, *outcome.edge, outcome.wanted)) continue;
      return false;
    }
    if (outcome.fault == TransformFault::kTooOld) {
      Frame& edge = *tree_->frames_.At(outcome.edge->id);
      const std::scoped_lock lock(edge.write);
      if (tree_->IsRestarting(edge)) {  // Then all waits are checked again.
        waiter.edge_ = &edge;
        waiter.from_stamp_ = std::numeric_limits<std::int64_t>::max();
        return false;
      }
      if (tree_->restarted_edges_.load(std::memory_order_relaxed) != restarted_edges) continue;
    }
    if (outcome.lagging != nullptr) {
      if (!Await(waiter, *outcome.lagging, outcome.wanted + 1)) continue;
      return false;
    }
    if (outcome.fault == TransformFault::kUnknownFrame || outcome.fault == TransformFault::kNotConnected) {
      const std::scoped_lock lock(tree_->topology_);
      if (tree_->edge_count_ != edges) continue;
      tree_->edges_are_awaited_ = true;
      waiter.edge_ = nullptr;
      return false;
    }
    result = tree_->Result(outcome);
    return true;
  }
}

}  // namespace hgros::tf

namespace hgros {

PendingTransform::PendingTransform(std::weak_ptr<tf::Waits> waits, std::shared_ptr<tf::Waiter> waiter)
    : waits_(std::move(waits)), waiter_(std::move(waiter)) {}

PendingTransform& PendingTransform::operator=(PendingTransform&& other) noexcept {
  if (this != &other) {
    Cancel();
    waits_ = std::move(other.waits_);
    waiter_ = std::move(other.waiter_);
  }
  return *this;
}

PendingTransform::~PendingTransform() { Cancel(); }

void PendingTransform::Cancel() {
  if (!waiter_) return;
  if (const auto waits = waits_.lock()) waits->Remove(waiter_);
  waiter_->Cancel();
  waiter_.reset();
}

bool PendingTransform::pending() const noexcept { return waiter_ && waiter_->pending(); }

}  // namespace hgros
