#pragma once

#include <functional>

namespace hgros {

// For the callback that the calling thread runs: a function that lets the messages of its subscription wait in their
// queue (true), or go on (false). The running callback may still get some that it has taken out already. Null outside
// callbacks, and if the executor has no queue. It may outlive the subscription, and does nothing then.
//
// Thread safety: the function may be called on any thread, also inside the callback.
[[nodiscard]] std::function<void(bool)> SuspenderOfRunningNode();

}  // namespace hgros
