#pragma once

#include <memory>
#include <string>

#include "hgros/base/bytes.hpp"
#include "hgros/base/export.hpp"
#include "hgros/codec/raw_message.hpp"

namespace google::protobuf {
class Descriptor;
class Message;
}  // namespace google::protobuf

namespace hgros {

/// A protobuf type that is known only at run time, from its publisher's description. Options and defaults in the
/// description are ignored, so a map is a list of entries. A description beyond the limits of CheckSchemas is refused.
///
/// Thread safety: all functions.
class HGROS_EXPORT DynamicSchema {
 public:
  /// Null if `schema` does not describe a protobuf type; `fault` then says why in one sentence. Takes 0.1 ms or more:
  /// call it once per MessageSchema, not per message.
  [[nodiscard]] static std::shared_ptr<const DynamicSchema> Build(const MessageSchema& schema, std::string& fault);
  DynamicSchema(const DynamicSchema&) = delete;
  DynamicSchema& operator=(const DynamicSchema&) = delete;
  ~DynamicSchema();

  [[nodiscard]] const google::protobuf::Descriptor& descriptor() const noexcept;
  /// The message in `bytes`, with reflection; null if they do not parse. It must not outlive this object.
  [[nodiscard]] std::unique_ptr<google::protobuf::Message> Read(Bytes bytes) const;

 private:
  struct Parts;
  explicit DynamicSchema(std::unique_ptr<Parts> parts);
  const std::unique_ptr<Parts> parts_;
};

}  // namespace hgros
