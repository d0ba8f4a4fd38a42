#include "graph/tbb_executor.hpp"

#include <algorithm>
#include <thread>
#include <utility>

#include "hgros/graph/helping.hpp"

namespace hgros {
namespace {

int WorkerCount(int wanted) {
  return wanted > 0 ? wanted : std::max(1, static_cast<int>(std::thread::hardware_concurrency()) - 1);
}

// By value, so that the token itself is read inside TBB's code, which put it there.
tbb::flow::continue_msg RunToken(TbbExecutor::Token token) noexcept {
  (void)token->handed_over.load(std::memory_order_acquire);
  const std::shared_ptr<Activation> activation = std::move(token->activation);
  if (token->owned) delete token;
  activation->Activate();
  return {};
}

}  // namespace

// TBB starts one thread less than it is allowed, for the caller that usually joins in; ours does not.
TbbExecutor::TbbExecutor(int threads)
    : workers_(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(WorkerCount(threads)) + 1),
      arena_(WorkerCount(threads), 0) {
  arena_.execute([this] { graph_ = std::make_unique<tbb::flow::graph>(); });
}

TbbExecutor::~TbbExecutor() {
  graph_->wait_for_all();
  nodes_.clear();
}

TbbExecutor::FlowNode& TbbExecutor::Take() {
  const std::scoped_lock lock(mutex_);
  if (free_.empty()) {
    nodes_.push_back(std::make_unique<FlowNode>(*graph_, tbb::flow::unlimited, &RunToken));
    return *nodes_.back();
  }
  FlowNode& node = *free_.back();
  free_.pop_back();
  return node;
}

void TbbExecutor::Put(FlowNode& node, std::shared_ptr<Activation> activation) {
  auto ticket = std::make_unique<Ticket>();
  ticket->owned = true;
  Put(node, std::move(activation), *ticket.release());  // An unlimited node takes everything.
}

void TbbExecutor::Put(FlowNode& node, std::shared_ptr<Activation> activation, Ticket& ticket) {
  ticket.activation = std::move(activation);
  ticket.handed_over.store(true, std::memory_order_release);
  node.try_put(&ticket);
}

bool TbbExecutor::LeavesToHelper(const std::shared_ptr<Activation>& activation) const noexcept {
  return Helping::Keep(activation, helped_);
}

void TbbExecutor::Give(FlowNode& node) {
  const std::scoped_lock lock(mutex_);
  free_.push_back(&node);
}

}  // namespace hgros
