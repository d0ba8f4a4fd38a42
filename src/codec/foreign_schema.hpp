#pragma once

#include <memory>
#include <string>
#include <string_view>

namespace google::protobuf {
class Descriptor;
class DescriptorPool;
}  // namespace google::protobuf

namespace hgros {

// A type built from a peer's descriptors.
struct ForeignSchema {
  std::shared_ptr<const google::protobuf::DescriptorPool> pool;
  const google::protobuf::Descriptor* type = nullptr;  // Lives in the pool.
  std::string fault;                                   // Completes "The peer's schema "; then there is no type.
};

enum class EnumValues { kKept, kLeftOut };

// `descriptor_set` may contain anything. A set that is too large to be built quickly is refused. Options and defaults
// are omitted, and nothing is logged. CheckSchemas has the limits.
[[nodiscard]] ForeignSchema BuildForeignSchema(std::string_view descriptor_set, const std::string& type_name,
                                               EnumValues enum_values);

}  // namespace hgros
