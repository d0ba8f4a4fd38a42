#include "hgros/graph/queue.hpp"

#include "hgros/base/error.hpp"

namespace hgros {

Queue Queue::KeepLast(std::size_t depth) {
  if (depth == 0) throw Error("A keep-last queue cannot have depth 0.", {}, "Use 1 or more.");
  Queue queue;
  queue.depth_ = depth;
  return queue;
}

Queue Queue::Latest() { return KeepLast(1); }

Queue Queue::KeepAll(std::size_t messages, std::size_t bytes) {
  if (messages == 0 || bytes == 0) {
    throw Error("A keep-all queue cannot have room for 0 messages or bytes.", {}, "Use 1 or more.");
  }
  Queue queue;
  queue.kind_ = Kind::kKeepAll;
  queue.depth_ = messages;
  queue.limit_bytes_ = bytes;
  return queue;
}

}  // namespace hgros
