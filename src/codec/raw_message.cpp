#include "hgros/codec/raw_message.hpp"

#include "hgros/codec/schema_compatibility.hpp"

namespace hgros {
namespace {

// Its messages are RawMessages, made by the library alone: no type of a program's is taken for it.
struct Any {};

TypeInfo MakeAnyType() {
  TypeInfo info;
  info.name = "raw bytes";
  info.cpp_type = typeid(Any);
  info.any = true;
  info.memory_bytes = [](const void* message) {
    return sizeof(RawMessage) + static_cast<const RawMessage*>(message)->data.bytes.size();
  };
  return info;
}

}  // namespace

const TypeInfo& AnyType() noexcept {
  static const TypeInfo info = MakeAnyType();
  return info;
}

MessageSchema SchemaOf(const TypeInfo& type) {
  return {type.name, type.encoding, type.fingerprint,
          type.descriptor_set == nullptr ? std::string() : type.descriptor_set()};
}

std::string MisfitOf(const MessageSchema& theirs, const TypeInfo& ours) {
  if (!theirs.type_name.empty() && theirs.type_name != ours.name) {
    return "the type is " + theirs.type_name + " there and " + ours.name + " here";
  }
  if (theirs.encoding != Encoding::kNone && theirs.encoding != ours.encoding) return "it is encoded in another way";
  if (theirs.fingerprint == 0 || ours.fingerprint == 0 || theirs.fingerprint == ours.fingerprint) return {};
  if (ours.encoding != Encoding::kProtobuf || ours.descriptor == nullptr)
    return "its " + ours.name + " has another layout";
  if (theirs.descriptor_set.empty()) return {};  // A plain publisher's, which is trusted.
  const SchemaVerdict verdict = CheckSchemas(theirs.descriptor_set, ours.name, *ours.descriptor());
  return verdict.compatible ? std::string() : verdict.reason;
}

}  // namespace hgros
