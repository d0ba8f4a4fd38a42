#include "transport/leader_pool.hpp"

#include <sched.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "hgros/base/system_limits.hpp"
#include "hgros/base/thread_local.hpp"
#include "hgros/transport/acting_thread.hpp"

namespace hgros {
namespace {

constexpr std::size_t kStanding = 2;  // Threads that wait for input. Others are parked, and end after a while.
constexpr auto kRetireAfter = std::chrono::seconds(5);

HGROS_THREAD_LOCAL bool visits = false;
// Of a thread that runs a task in ReceiveHere().
enum class Rest { kStays, kNone, kLeft };
HGROS_THREAD_LOCAL Rest rest = Rest::kStays;

}  // namespace

struct LeaderPool::State {
  explicit State(Input& what) : input(what) {}

  /// Under the mutex: moves the calling thread to `retired`, where another thread joins it.
  void Retire() {
    const auto self = threads.find(std::this_thread::get_id());
    retired.push_back(std::move(self->second));
    threads.erase(self);
  }

  Input& input;  // Once `stop` is set, only threads that Stop() joins touch it.
  std::mutex mutex;
  std::condition_variable turn;    // The leader has finished.
  std::condition_variable needed;  // A parked thread is needed.
  std::map<std::thread::id, std::thread> threads;
  std::vector<std::thread> retired;  // Have left Run(), still to be joined.
  std::size_t standing = 0;          // Threads inside Wait() or Lead(), or between them.
  std::size_t parked = 0;
  std::deque<Task> handed_over;  // Read by a visitor.
  bool led = false;              // A thread is inside Lead().
  bool visited = false;          // A thread is inside Receive() or ReceiveHere().
  std::thread::id stays;         // The thread inside ReceiveHere().
  bool stop = false;
};

LeaderPool::LeaderPool(Input& input) : state_(std::make_shared<State>(input)) {}

LeaderPool::~LeaderPool() { Stop(); }

void LeaderPool::Start() {
  const std::scoped_lock lock(state_->mutex);
  if (state_->stop || !state_->threads.empty()) return;
  try {
    for (std::size_t i = 0; i < kStanding; ++i) Spawn(state_);
  } catch (const std::system_error&) {
    ThrowNoThread("the threads that receive messages");
  }
}

void LeaderPool::Spawn(const std::shared_ptr<State>& state) {
  std::thread thread([state] { Run(state); });
  const auto id = thread.get_id();
  state->threads.emplace(id, std::move(thread));
}

void LeaderPool::Run(const std::shared_ptr<State>& state) {
  std::unique_lock lock(state->mutex);
  while (!state->stop) {
    if (state->standing >= kStanding) {
      ++state->parked;
      const bool late = state->needed.wait_for(lock, kRetireAfter) == std::cv_status::timeout;
      --state->parked;
      if (late && !state->stop && state->standing >= kStanding) {
        state->Retire();
        return;
      }
      continue;
    }
    ++state->standing;
    lock.unlock();
    state->input.Wait();
    lock.lock();
    if (state->stop) {
      state->input.Wake();  // One wake-up ends one wait: this one is for the next thread.
      return;
    }
    state->turn.wait(lock, [&] { return !state->led || state->stop; });
    if (state->stop) return;
    state->led = true;
    auto gone = std::exchange(state->retired, {});
    lock.unlock();
    for (auto& thread : gone) thread.join();
    gone.clear();
    Task task = state->input.Lead();
    lock.lock();
    if (!task && !state->handed_over.empty()) {
      task = std::move(state->handed_over.front());
      state->handed_over.pop_front();
    }
    state->led = false;
    --state->standing;
    if (task && state->standing == 0 && !state->stop) {
      if (state->parked > 0) {
        state->needed.notify_one();
      } else {
        try {
          Spawn(state);
        } catch (const std::system_error&) {
          // The system has no more threads: reading pauses until a task ends.
        }
      }
    }
    state->turn.notify_one();  // Perhaps a thread in ReceiveHere() waits, which does not stand.
    if (!task) continue;
    const bool more = !state->handed_over.empty();
    lock.unlock();
    if (more) state->input.Wake();
    task();
    task = nullptr;  // Its last reference may run a destructor: not under the lock.
    lock.lock();
  }
}

bool Transport::IsVisitor() noexcept { return visits; }

bool Transport::LeaveRest() noexcept {
  if (visits || rest == Rest::kStays) return false;
  rest = Rest::kLeft;
  return true;
}

void LeaderPool::Receive(const Visit& visit) noexcept {
  const auto keeps = state_;  // A thread in Stop() may destroy the pool before this function returns.
  State& state = *keeps;
  bool may = false;
  {
    const std::scoped_lock lock(state.mutex);
    may = !state.stop && !state.visited && !state.threads.empty();
    state.visited = state.visited || may;
  }
  if (!may) return visit.first();
  if (state.input.BeginAsking()) {
    visit.first();
    visits = true;
    while (!visit.done()) {
      const bool late = std::chrono::steady_clock::now() >= visit.until;
      const bool read = state.input.MayRead() && LeadOnce(state);
      if (late) break;
      if (!read) sched_yield();  // The sender of the awaited message, or a thread of the pool, may need this core.
    }
    visits = false;
    state.input.EndAsking();
  } else {
    visit.first();
  }
  {
    const std::scoped_lock lock(state.mutex);
    state.visited = false;
  }
  state.turn.notify_all();  // A thread may wait in Stop().
}

bool LeaderPool::LeadOnce(State& state) noexcept {
  std::unique_lock lock(state.mutex);
  if (state.led || state.stop) return false;
  state.led = true;
  lock.unlock();
  Task task = state.input.Lead();
  const bool hands_over = static_cast<bool>(task);
  lock.lock();
  if (hands_over) state.handed_over.push_back(std::move(task));
  state.led = false;
  lock.unlock();
  state.turn.notify_one();
  if (hands_over) state.input.Wake();
  return true;
}

bool LeaderPool::LeftRest() noexcept { return rest == Rest::kLeft; }

bool LeaderPool::ReceiveHere(const Visit& visit) noexcept {
  const auto keeps = state_;  // A task may destroy the pool.
  Task task;                  // Destroyed after the lock.
  State& state = *keeps;
  std::unique_lock lock(state.mutex);
  if (state.stop || state.visited || state.threads.empty() || !state.input.CanWaitFirst()) return false;
  state.visited = true;
  state.stays = std::this_thread::get_id();
  const auto ends = [&] {
    {
      const std::scoped_lock inside(state.mutex);
      if (state.stop) return true;
    }
    return visit.done();
  };
  lock.unlock();
  bool goes_on = !ends();
  while (goes_on) {
    goes_on = state.input.WaitFirst(ends, visit.until) && std::chrono::steady_clock::now() < visit.until;
    lock.lock();
    state.turn.wait(lock, [&] { return !state.led || state.stop; });
    if (state.stop) {
      state.input.Wake();  // It may have ended this wait in place of that of a thread of the pool.
      break;
    }
    state.led = true;
    lock.unlock();
    visits = true;
    task = state.input.Lead();
    visits = false;
    lock.lock();
    if (!task && !state.handed_over.empty()) {
      task = std::move(state.handed_over.front());
      state.handed_over.pop_front();
      state.input.EndAsking();  // Input wakes others while the task runs; after a task of Lead() it does already.
    }
    state.led = false;
    state.turn.notify_one();
    if (!state.handed_over.empty()) state.input.Wake();
    lock.unlock();
    rest = Rest::kNone;
    if (task) task();
    const bool leaves = std::exchange(rest, Rest::kStays) == Rest::kLeft;
    if (!leaves) task = nullptr;
    goes_on = goes_on && !ends();
    lock.lock();
    if (state.stop) break;  // Perhaps the task has destroyed the pool.
    if (leaves) {
      state.handed_over.push_back(std::exchange(task, nullptr));
      state.input.Wake();
    }
    lock.unlock();
  }
  if (!lock.owns_lock()) lock.lock();
  if (!state.stop) state.input.EndAsking();
  state.visited = false;
  state.stays = {};
  lock.unlock();
  state.turn.notify_all();  // A thread may wait in Stop().
  return true;
}

void LeaderPool::WakeReceiver() noexcept { state_->input.WakeFirst(); }

void LeaderPool::Stop() noexcept {
  std::map<std::thread::id, std::thread> threads;
  std::vector<std::thread> retired;
  std::deque<Task> left;  // Destroyed after the lock.
  {
    std::unique_lock lock(state_->mutex);
    state_->stop = true;
    if (state_->visited && state_->stays != ActingThread::Id()) {
      state_->input.WakeFirst();
      state_->turn.notify_all();
      state_->turn.wait(lock, [this] { return !state_->visited; });
    }
    threads.swap(state_->threads);
    retired.swap(state_->retired);
    left.swap(state_->handed_over);
  }
  state_->turn.notify_all();
  state_->needed.notify_all();
  if (!threads.empty()) state_->input.Wake();
  for (auto& [id, thread] : threads) {
    if (id == ActingThread::Id()) {
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
