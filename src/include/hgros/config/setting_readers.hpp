#pragma once

#include <vector>

#include "hgros/graph/node_options.hpp"
#include "hgros/yaml/reader.hpp"

// Settings that a robot file has, too. The functions report ConfigErrors.
namespace hgros {

/// A map from node names to their executor and queue.
[[nodiscard]] NodeOverrides ReadNodeOverrides(const yaml::Value& map);
/// A list of distinct CPU numbers, sorted.
[[nodiscard]] std::vector<int> ReadCpus(const yaml::Value& list);

}  // namespace hgros
