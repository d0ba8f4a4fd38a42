#pragma once

#include <string>

#include "hgros/codec/raw_message.hpp"

namespace hgros::cli {

/// A protobuf type that no program is compiled with: message robot.Grip { double width = 1; string name = 2; }.
[[nodiscard]] MessageSchema GripSchema();
/// One message of it.
[[nodiscard]] std::string GripBytes(double width, const std::string& name);

}  // namespace hgros::cli
