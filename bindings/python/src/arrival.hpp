#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <variant>

#include "hgros/base/bytes.hpp"
#include "hgros/base/cause.hpp"
#include "hgros/base/log.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/graph/message_info.hpp"

namespace hgros::python {

/// A message for a subscription of Python.
struct Heard {
  RawMessage message;
  MessageInfo info;
  Cause cause;  ///< Of what Python publishes while it handles the message.
};

/// A line of the library's log.
struct LogLine {
  LogLevel level = LogLevel::kInfo;
  std::string text;
};

/// What an Inbox holds. None of it belongs to Python, so any thread may drop it without the GIL.
using Arrival = std::variant<Heard, LogLine>;

[[nodiscard]] inline std::size_t BytesOf(const Arrival& arrival) noexcept {
  const auto* heard = std::get_if<Heard>(&arrival);
  return heard != nullptr ? heard->message.data.bytes.size() : 0;
}

}  // namespace hgros::python
