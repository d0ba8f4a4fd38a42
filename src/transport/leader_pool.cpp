#include "transport/leader_pool.hpp"

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace hgros {
namespace {

// One follower always stands by, so that passing the turn on costs a wake-up and not a new thread. Others go after a
// while.
constexpr std::size_t kKeptIdle = 1;
constexpr auto kRetireAfter = std::chrono::seconds(5);

}  // namespace

struct LeaderPool::State {
  explicit State(Input& what) : input(what) {}

  Input& input;  // Not touched once `stop` is set, except by threads that Stop() joins.
  std::mutex mutex;
  std::condition_variable turn;
  std::map<std::thread::id, std::thread> threads;
  std::vector<std::thread> retired;  // Have left Run(), still to be joined.
  std::size_t idle = 0;
  bool led = false;  // A thread is inside Lead().
  bool stop = false;
};

LeaderPool::LeaderPool(Input& input) : state_(std::make_shared<State>(input)) {}

LeaderPool::~LeaderPool() { Stop(); }

void LeaderPool::Start() {
  const std::scoped_lock lock(state_->mutex);
  if (state_->stop || !state_->threads.empty()) return;
  SpawnLocked(state_);
  SpawnLocked(state_);
}

void LeaderPool::SpawnLocked(const std::shared_ptr<State>& state) {
  std::thread thread([state] { Run(state); });
  const auto id = thread.get_id();
  state->threads.emplace(id, std::move(thread));
}

void LeaderPool::Run(const std::shared_ptr<State>& state) {
  std::unique_lock lock(state->mutex);
  for (;;) {
    // Wait for the turn; a surplus follower retires.
    ++state->idle;
    while (state->led && !state->stop) {
      if (state->idle <= kKeptIdle) {
        state->turn.wait(lock);
      } else if (state->turn.wait_for(lock, kRetireAfter) == std::cv_status::timeout && state->led && !state->stop &&
                 state->idle > kKeptIdle) {
        --state->idle;
        const auto self = state->threads.find(std::this_thread::get_id());
        state->retired.push_back(std::move(self->second));
        state->threads.erase(self);
        return;
      }
    }
    --state->idle;
    if (state->stop) return;
    state->led = true;
    auto gone = std::exchange(state->retired, {});
    lock.unlock();
    for (auto& thread : gone) thread.join();
    Task task = state->input.Lead();
    lock.lock();
    state->led = false;
    if (!task) {
      if (state->stop) return;
      continue;
    }
    if (state->idle == 0 && !state->stop) {
      try {
        SpawnLocked(state);
      } catch (const std::system_error&) {
        // No more threads: waiting pauses until this task or another one ends.
      }
    }
    lock.unlock();
    state->turn.notify_one();
    task();
    task = nullptr;  // Its last reference may run a destructor: not under the lock.
    lock.lock();
  }
}

void LeaderPool::Stop() noexcept {
  std::map<std::thread::id, std::thread> threads;
  std::vector<std::thread> retired;
  {
    const std::scoped_lock lock(state_->mutex);
    state_->stop = true;
    threads.swap(state_->threads);
    retired.swap(state_->retired);
  }
  state_->turn.notify_all();
  if (threads.empty()) return;
  state_->input.Wake();
  for (auto& [id, thread] : threads) {
    if (id == std::this_thread::get_id()) {
      thread.detach();
    } else {
      thread.join();
    }
  }
  for (auto& thread : retired) thread.join();
}

std::size_t LeaderPool::thread_count() const {
  const std::scoped_lock lock(state_->mutex);
  return state_->threads.size();
}

}  // namespace hgros
