#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "hgros/base/bytes.hpp"

namespace hgros::python {

/// The wire form of a message: one `bytes` field of it where it is, and the rest.
struct BulkWire {
  std::string head;      ///< All other fields.
  std::size_t at = 0;    ///< Where the field's bytes begin.
  std::size_t size = 0;  ///< Their number; 0 if the field does not occur.
};

/// Splits at the last occurrence of field `number`. Empty if `wire` is not a protobuf message.
[[nodiscard]] std::optional<BulkWire> SplitBulk(Bytes wire, int number);

/// What comes before `size` bytes of field `number`: its tag and its length.
[[nodiscard]] std::string BulkPrefix(int number, std::size_t size);

}  // namespace hgros::python
