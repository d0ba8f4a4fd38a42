#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "hgros/base/log.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/graph/executor.hpp"
#include "hgros/graph/invoke.hpp"
#include "hgros/graph/queue.hpp"

namespace hgros {

class GraphCore;

// How long a thread runs message after message while others may wait for it.
inline constexpr std::int64_t kTurnNs = 1'000'000;

// The settings of a node. `on_room` is called without locks when a message has left a lossless queue.
struct NodeSetting {
  std::string name;
  std::string channel;
  Invoke invoke = Invoke::kSerial;
  Queue queue;
  Executor executor;
  GraphCore* graph = nullptr;
  std::shared_ptr<Log> log;
  std::function<void()> on_room;
  const TypeInfo* type = nullptr;  // The type that the callback takes.
  // Converts a message to that type; null if it fails. Used only on channels with two types.
  std::function<AnyMessage(const AnyMessage&)> in_form;
};

}  // namespace hgros
