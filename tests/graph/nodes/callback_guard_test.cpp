#include "graph/nodes/callback_guard.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "graph/nodes/callback_scope.hpp"

namespace hgros {
namespace {

TEST(CallbackGuard, DestroysTheCallbackOnceOutsideTheLockAndInsideTheNode) {
  int object = 0;
  auto* const node = reinterpret_cast<Node*>(&object);  // Only compared.
  std::mutex mutex;
  std::condition_variable changed;
  CallbackGuard* guarded = nullptr;
  int destroyed = 0;
  const auto on_destruction = [&](const int* /*object*/) {
    ++destroyed;
    EXPECT_TRUE(CallbackScope::InNode(node));
    std::unique_lock lock(mutex, std::try_to_lock);
    ASSERT_TRUE(lock.owns_lock()) << "the callback is destroyed under the node's lock";
    EXPECT_TRUE(guarded->destroying());
    guarded->DestroyOnce(nullptr, node, lock,
                         changed);  // As if an object that the callback owns closed the node again.
    EXPECT_EQ(destroyed, 1);
  };
  CallbackGuard guard(
      [captured = std::shared_ptr<const int>(&object, on_destruction)](const AnyMessage&, const MessageInfo&) {});
  guarded = &guard;
  std::unique_lock lock(mutex);
  guard.DestroyOnce(nullptr, node, lock, changed);
  EXPECT_TRUE(lock.owns_lock());
  EXPECT_FALSE(guard.destroying());
  guard.DestroyOnce(nullptr, node, lock, changed);
  EXPECT_EQ(destroyed, 1);
}

}  // namespace
}  // namespace hgros
