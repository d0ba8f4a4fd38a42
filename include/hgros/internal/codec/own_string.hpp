#pragma once

#include <memory>
#include <string>
#include <utility>

#include "hgros/base/bytes.hpp"
#include "hgros/codec/type_info.hpp"

namespace hgros::codec {

/// A payload that owns the string.
inline Payload OwnString(std::shared_ptr<const std::string> text) {
  const Bytes bytes = AsBytes(*text);
  return {bytes, std::move(text)};
}

}  // namespace hgros::codec
