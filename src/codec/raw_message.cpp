#include "hgros/codec/raw_message.hpp"

#include <cstring>

#include "hgros/codec/run_time_type.hpp"
#include "hgros/codec/schema_compatibility.hpp"

namespace hgros {
namespace {

// The C++ type of AnyType(), whose messages are RawMessages made by the library. No type of a program is equal to it.
struct Any {};

const Payload& DataOf(const void* message) { return static_cast<const RawMessage*>(message)->data; }

TypeInfo MakeAnyType() {
  TypeInfo info;
  info.name = "raw bytes";
  info.cpp_type = typeid(Any);
  info.any = true;
  info.memory_bytes = [](const void* message) { return sizeof(RawMessage) + DataOf(message).bytes.size(); };
  info.encode = [](const AnyMessage& message) { return DataOf(message.get()); };
  info.encode_in_place = [](const void* message) { return DataOf(message); };
  info.large_part = [](const void* message) { return DataOf(message).bytes; };
  info.encoded_bytes = [](const void* message) { return DataOf(message).bytes.size(); };
  info.encode_into = [](const void* message, std::span<std::byte> bytes) {
    const Bytes data = DataOf(message).bytes;
    if (!data.empty()) std::memcpy(bytes.data(), data.data(), data.size());
    return true;
  };
  // Without the schema: the reader of the message adds it.
  info.decode = [](const Payload& payload) -> AnyMessage {
    return std::make_shared<const RawMessage>(RawMessage{nullptr, payload});
  };
  return info;
}

}  // namespace

const TypeInfo& AnyType() noexcept {
  static const TypeInfo info = MakeAnyType();
  return info;
}

MessageSchema SchemaOf(const TypeInfo& type) {
  return {type.name, type.encoding, type.fingerprint, DescriptorSetOf(type)};
}

std::string MisfitOf(const MessageSchema& theirs, const TypeInfo& ours) {
  if (!theirs.type_name.empty() && theirs.type_name != ours.name) {
    return "the type is " + theirs.type_name + " there and " + ours.name + " here";
  }
  if (theirs.encoding != Encoding::kNone && theirs.encoding != ours.encoding) return "it is encoded in another way";
  if (theirs.fingerprint == 0 || ours.fingerprint == 0 || theirs.fingerprint == ours.fingerprint) return {};
  const google::protobuf::Descriptor* const descriptor = DescriptorOf(ours);
  if (ours.encoding != Encoding::kProtobuf || descriptor == nullptr) {
    return "its " + ours.name + " has another layout";
  }
  if (theirs.descriptor_set.empty()) return {};  // A publisher that sends no descriptor set is trusted.
  const SchemaVerdict verdict = CheckSchemas(theirs.descriptor_set, ours.name, *descriptor);
  return verdict.compatible ? std::string() : verdict.reason;
}

}  // namespace hgros
