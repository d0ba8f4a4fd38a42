#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <typeindex>
#include <vector>

#include "hgros/codec/raw_message.hpp"
#include "hgros/codec/type_info.hpp"

namespace hgros {

// The data that one channel needs to convert messages to RawMessages and back: its own schema, and the schemas of
// others that were compared with it. Empty until it is needed.
//
// Thread safety: all functions.
class RawForms {
 public:
  // Null: the type never leaves the process, or its codec cannot write the message.
  [[nodiscard]] AnyMessage ToRaw(const AnyMessage& message, const TypeInfo& type);
  // Null: it is of another type, or does not parse.
  [[nodiscard]] AnyMessage FromRaw(const RawMessage& message, const TypeInfo& type);

 private:
  struct Compared {
    std::weak_ptr<const MessageSchema> theirs;
    std::type_index ours;
    bool fits;
  };
  [[nodiscard]] std::shared_ptr<const MessageSchema> OwnSchema(const TypeInfo& type);
  [[nodiscard]] bool Fits(const std::shared_ptr<const MessageSchema>& theirs, const TypeInfo& ours);

  std::mutex mutex_;
  std::shared_ptr<const MessageSchema> own_;
  std::vector<Compared> compared_;
};

}  // namespace hgros
