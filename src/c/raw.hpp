#pragma once

#include <memory>
#include <utility>

#include "c/calling.hpp"
#include "hgros/c/message.h"
#include "hgros/codec/raw_message.hpp"
#include "hgros/graph/message_info.hpp"

struct hgros_schema {
  std::shared_ptr<const hgros::MessageSchema> schema;
};

// A lease on the heap, or on the stack around a callback.
struct hgros_message {
  std::shared_ptr<const hgros::RawMessage> raw;  // Null until there is a message.
  hgros_schema schema;
  hgros::MessageInfo info;

  hgros_message() = default;
  explicit hgros_message(std::shared_ptr<const hgros::RawMessage> message, const hgros::MessageInfo& its_info = {}) {
    Fill(std::move(message), its_info);
  }
  void Fill(std::shared_ptr<const hgros::RawMessage> message, const hgros::MessageInfo& its_info) noexcept {
    raw = std::move(message);
    schema.schema = raw->schema;
    info = its_info;
  }
};

namespace hgros::c {

// Counts a lease that the caller gets.
void CountLease() noexcept;
// A message that the caller frees; counted as a lease.
std::unique_ptr<hgros_message> NewLease(std::shared_ptr<const RawMessage> raw, const MessageInfo& info = {});

inline const MessageSchema& SchemaIn(const hgros_schema* schema, const char* argument) {
  return *Given(schema, argument).schema;
}
// Borrows the caller's bytes, which are copied by who keeps them. Null is allowed for no bytes.
inline Payload Borrowed(const void* data, std::size_t size) {
  if (data == nullptr && size > 0) RefuseNull("data");
  return {Bytes(static_cast<const std::byte*>(data), size), nullptr};
}

}  // namespace hgros::c
