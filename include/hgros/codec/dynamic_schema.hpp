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

/// A protobuf type that this program was built without, as its publisher describes it. What the description says of
/// options and defaults is left out, so that a map is a list of entries; it is refused if it is larger than
/// CheckSchemas takes.
///
/// Thread safety: all functions.
class HGROS_EXPORT DynamicSchema {
 public:
  /// Null if `schema` describes no protobuf type; `fault` then says why in a sentence. Takes from 0.1 ms up: once for
  /// each MessageSchema, not for each message.
  [[nodiscard]] static std::shared_ptr<const DynamicSchema> Build(const MessageSchema& schema, std::string& fault);
  DynamicSchema(const DynamicSchema&) = delete;
  DynamicSchema& operator=(const DynamicSchema&) = delete;
  ~DynamicSchema();

  [[nodiscard]] const google::protobuf::Descriptor& descriptor() const noexcept;
  /// The message that `bytes` are, with reflection; null if they do not parse. It must not outlive this.
  [[nodiscard]] std::unique_ptr<google::protobuf::Message> Read(Bytes bytes) const;

 private:
  struct Parts;
  explicit DynamicSchema(std::unique_ptr<Parts> parts);
  const std::unique_ptr<Parts> parts_;
};

}  // namespace hgros
