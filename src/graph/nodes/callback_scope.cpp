#include "graph/nodes/callback_scope.hpp"

namespace hgros {
namespace {

thread_local CallbackScope* innermost = nullptr;

}  // namespace

CallbackScope::CallbackScope(const void* graph, const void* node) noexcept
    : graph_(graph), node_(node), outer_(innermost) {
  innermost = this;
}

CallbackScope::~CallbackScope() { innermost = outer_; }

bool CallbackScope::InAny() noexcept { return innermost != nullptr; }

bool CallbackScope::InGraph(const void* graph) noexcept {
  for (const CallbackScope* scope = innermost; scope != nullptr; scope = scope->outer_) {
    if (scope->graph_ == graph) return true;
  }
  return false;
}

bool CallbackScope::InNode(const void* node) noexcept {
  for (const CallbackScope* scope = innermost; scope != nullptr; scope = scope->outer_) {
    if (scope->node_ == node) return true;
  }
  return false;
}

}  // namespace hgros
