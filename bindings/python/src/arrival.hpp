#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "answer.hpp"
#include "hgros/base/bytes.hpp"
#include "hgros/base/cause.hpp"
#include "hgros/base/log.hpp"
#include "hgros/clock/periodic_schedule.hpp"
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

/// The end of a call: a reply, or the kind and the reason of a failure.
struct CallEnded {
  RawMessage reply;
  std::string kind;  ///< Empty: there is a reply.
  std::string reason;
};

/// A request to a service of Python, whose handler waits for the answer.
struct Request {
  RawMessage message;
  std::shared_ptr<Answer> answer;
};

/// What a thread of Python does for a thread of the library, which waits for the answer without the GIL.
struct Work {
  std::function<std::string()> run;
  std::shared_ptr<Answer> answer;
};

/// Paths of parameters that have changed.
struct ParamsChanged {
  std::vector<std::string> paths;
};

/// What an Inbox holds. None of it belongs to Python, so any thread may drop it without the GIL.
using Arrival = std::variant<Heard, LogLine, Tick, CallEnded, Request, ParamsChanged, Work>;

[[nodiscard]] inline std::size_t BytesOf(const Arrival& arrival) noexcept {
  const auto* heard = std::get_if<Heard>(&arrival);
  return heard != nullptr ? heard->message.data.bytes.size() : 0;
}

}  // namespace hgros::python
