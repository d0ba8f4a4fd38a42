#include "graph/nodes/callback_scope.hpp"

#include "graph/graph_core.hpp"
#include "hgros/base/thread_cause.hpp"
#include "hgros/base/thread_local.hpp"

namespace hgros {
namespace {

HGROS_THREAD_LOCAL CallbackScope* innermost = nullptr;

}  // namespace

// exit() destroys the calling thread's object before all static objects.
struct CallbackScope::ExitWatch {
  ~ExitWatch() {
    for (const CallbackScope* scope = innermost; scope != nullptr; scope = scope->outer_) {
      if (scope->graph_ != nullptr) scope->graph_->OnExitInside();
    }
  }
};

CallbackScope::CallbackScope(GraphCore* graph, Node* node, const Cause& cause) noexcept
    : graph_(graph), node_(node), outer_(innermost), cause_(cause), outer_cause_(thread_cause) {
  HGROS_THREAD_LOCAL ExitWatch watch;  // Made at the thread's first callback.
  innermost = this;
  thread_cause = &cause_;
}

CallbackScope::~CallbackScope() {
  innermost = outer_;
  thread_cause = outer_cause_;
}

bool CallbackScope::InAny() noexcept { return innermost != nullptr; }

bool CallbackScope::InGraph(const GraphCore* graph) noexcept {
  for (const CallbackScope* scope = innermost; scope != nullptr; scope = scope->outer_) {
    if (scope->graph_ == graph) return true;
  }
  return false;
}

bool CallbackScope::InNode(const Node* node) noexcept {
  for (const CallbackScope* scope = innermost; scope != nullptr; scope = scope->outer_) {
    if (scope->node_ == node) return true;
  }
  return false;
}

const Node* CallbackScope::NodeOf(const GraphCore* graph) noexcept {
  for (const CallbackScope* scope = innermost; scope != nullptr; scope = scope->outer_) {
    if (scope->graph_ == graph && scope->node_ != nullptr) return scope->node_;
  }
  return nullptr;
}

Node* CallbackScope::Innermost() noexcept { return innermost == nullptr ? nullptr : innermost->node_; }

std::vector<const Node*> CallbackScope::Nodes() {
  std::vector<const Node*> nodes;
  for (const CallbackScope* scope = innermost; scope != nullptr; scope = scope->outer_) nodes.push_back(scope->node_);
  return nodes;
}

}  // namespace hgros
