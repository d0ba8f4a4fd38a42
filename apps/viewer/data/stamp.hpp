#pragma once

#include "google/protobuf/timestamp.pb.h"
#include "hgros/clock/time.hpp"

namespace hgros::viewer {

/// The timestamp of a message.
[[nodiscard]] inline Time StampOf(const google::protobuf::Timestamp& stamp) noexcept {
  return {stamp.seconds() * 1'000'000'000 + stamp.nanos()};
}

}  // namespace hgros::viewer
