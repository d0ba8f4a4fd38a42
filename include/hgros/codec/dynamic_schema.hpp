#pragma once

#include <cstddef>
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
  static constexpr std::size_t kMostMemoryBytes = std::size_t{256} << 20;
  /// The message in `bytes`, with reflection. It must not outlive this object. Null if they do not parse, or if the
  /// message would take more than `most_memory_bytes` of memory beyond their own size. This is estimated before, rather
  /// too high: two bytes may become an object of a hundred.
  [[nodiscard]] std::unique_ptr<google::protobuf::Message> Read(Bytes bytes,
                                                                std::size_t most_memory_bytes = kMostMemoryBytes) const;
  /// The same; if it is null, `fault` says why in one sentence.
  [[nodiscard]] std::unique_ptr<google::protobuf::Message> Read(Bytes bytes, std::string& fault,
                                                                std::size_t most_memory_bytes = kMostMemoryBytes) const;

 private:
  struct Parts;
  explicit DynamicSchema(std::unique_ptr<Parts> parts);
  const std::unique_ptr<Parts> parts_;
};

}  // namespace hgros
