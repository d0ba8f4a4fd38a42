#pragma once

#include <string_view>

#include "hgros/codec/type_info.hpp"
#include "hgros/graph/invoke.hpp"
#include "hgros/internal/base/call_site.hpp"

namespace hgros {

/// A subscription that a component asks for.
struct ComponentInput {
  std::string_view channel;
  const TypeInfo& type;
  Invoke invoke;
  const CallSite& where;
};

/// A service that a component offers.
struct ServedByComponent {
  std::string_view service;
  // The types of the two channels, then the types of the messages.
  const TypeInfo& request;
  const TypeInfo& reply;
  const TypeInfo& request_body;
  const TypeInfo& reply_body;
  Invoke invoke;
  const CallSite& where;
};

}  // namespace hgros
