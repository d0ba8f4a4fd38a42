#pragma once

#include <string>

#include "tracing/traced.hpp"

namespace hgros::cli {

/// The Chrome trace event format, which ui.perfetto.dev and chrome://tracing open: a span for each callback, a short
/// one for each publish outside callbacks, and arrows from publishes to the callbacks that handle the messages. Times
/// in us.
[[nodiscard]] std::string ChromeTraceOf(const Traced& traced);

}  // namespace hgros::cli
