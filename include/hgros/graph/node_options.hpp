#pragma once

#include <map>
#include <optional>
#include <string>

#include "hgros/graph/executor.hpp"
#include "hgros/graph/queue.hpp"

namespace hgros {

/// Settings of a node that the program chooses when it subscribes.
struct NodeOptions {
  std::string name{};  ///< For logs, tables and configuration; empty: channel and number, such as "scan#0".
  Queue queue{};
  Executor executor{};
};

/// Settings of a node from the configuration, found by its name; they replace those of the program.
struct NodeOverride {
  std::optional<Queue> queue;
  std::optional<Executor> executor;
};
using NodeOverrides = std::map<std::string, NodeOverride, std::less<>>;

}  // namespace hgros
