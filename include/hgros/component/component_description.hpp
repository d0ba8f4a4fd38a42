#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "hgros/clock/time.hpp"
#include "hgros/params/param_declaration.hpp"

namespace hgros {

/// A channel that a component publishes on or subscribes to.
struct ComponentChannel {
  std::string name;     ///< As the component calls it.
  std::string channel;  ///< As the robot calls it, after remapping.
  std::string type;     ///< The name of the message type; empty for a subscription to any type.
  std::string node;     ///< The node of a subscription, such as "mapper/scan"; empty for a publisher.
};

struct ComponentService {
  std::string name;
  std::string service;  ///< As the robot calls it.
  std::string request;  ///< Names of message types.
  std::string reply;
};

struct ComponentTimer {
  std::string name;
  Duration period{};
};

/// What a component uses, as its constructor declared it.
struct ComponentDescription {
  std::string name;
  std::string type;  ///< Such as "slam2d/Mapper".
  std::vector<ComponentChannel> inputs;
  std::vector<ComponentChannel> outputs;
  std::vector<ComponentService> services;  ///< Those that it serves.
  std::vector<ComponentService> calls;     ///< Those that it calls.
  std::vector<ComponentTimer> timers;
  std::vector<ParamDeclaration> params;
  bool transforms = false;  ///< It has called Context::transforms().
  std::string state;        ///< The type of its Save; empty if it has none.
  /// The schemas of all these types, by their names. 0: the type has none.
  std::map<std::string, std::uint64_t> fingerprints;
};

}  // namespace hgros
