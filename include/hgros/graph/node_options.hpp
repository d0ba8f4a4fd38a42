#pragma once

#include <map>
#include <optional>
#include <string>

#include "hgros/graph/executor.hpp"
#include "hgros/graph/queue.hpp"

namespace hgros {

/// What a program says of one node when it subscribes.
struct NodeOptions {
  std::string name{};  ///< For logs, tables and configuration; empty: channel and a number, as in "scan#0".
  Queue queue{};
  Executor executor{};
};

/// What configuration says of a node by its name; it wins over what the program says.
struct NodeOverride {
  std::optional<Queue> queue;
  std::optional<Executor> executor;
};
using NodeOverrides = std::map<std::string, NodeOverride, std::less<>>;

}  // namespace hgros
