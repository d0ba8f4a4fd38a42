#include "hgros/codec/run_time_type.hpp"

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <string>
#include <string_view>
#include <typeindex>
#include <utility>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/codec/dynamic_schema.hpp"
#include "hgros/codec/schema.hpp"
#include "hgros/codec/schema_match.hpp"
#include "hgros/internal/codec/call_message.hpp"

namespace hgros {
namespace {

struct RunTimeCall : CallMessage {};

struct RunTimeTypes {
  MessageSchema named;  // As given by the program, perhaps without a fingerprint.
  RunTimeSchema schema;
  TypeInfo message;
  TypeInfo call;
};

std::size_t CallMemoryBytes(const void* message) {
  const auto& call = *static_cast<const CallMessage*>(message);
  return sizeof(CallMessage) + (call.body ? call.type->memory_bytes(call.body.get()) : 0);
}

// Starts from AnyType(), whose functions read and write RawMessages.
TypeInfo MessageTypeOf(const RunTimeSchema& run_time) {
  TypeInfo type = AnyType();
  type.any = false;
  type.name = run_time.schema->type_name;
  type.encoding = run_time.schema->encoding;
  type.fingerprint = run_time.schema->fingerprint;
  type.run_time = &run_time;
  return type;
}

TypeInfo RawCallTypeOf(const TypeInfo& message) {
  TypeInfo type = message;
  type.cpp_type = typeid(RunTimeCall);
  type.memory_bytes = &CallMemoryBytes;
  type.encode = &codec::EncodeCall;
  type.encoded_bytes = &codec::EncodedCallBytes;
  type.encode_into = &codec::EncodeCallInto;
  type.encode_in_place = nullptr;
  type.large_part = nullptr;
  type.decode = [](const Payload& payload) { return codec::DecodeCall(payload, AnyType()); };
  return type;
}

std::unique_ptr<RunTimeTypes> MakeRunTimeTypes(const MessageSchema& named) {
  if (named.type_name.empty() || named.encoding == Encoding::kNone) {
    throw Error("A message type that is named at run time needs a name and an encoding.", {},
                "Fill in MessageSchema::type_name and MessageSchema::encoding.");
  }
  auto made = std::make_unique<RunTimeTypes>();
  made->named = named;
  MessageSchema schema = named;
  if (schema.encoding == Encoding::kProtobuf && !schema.descriptor_set.empty()) {
    std::string fault;
    made->schema.described = DynamicSchema::Build(schema, fault);
    if (!made->schema.described) {
      throw Error("The descriptor set of " + schema.type_name + " cannot be used: " + fault, {},
                  "Give a serialized google.protobuf.FileDescriptorSet with the type's file and all its imports, "
                  "dependencies first.");
    }
    schema.fingerprint = SchemaFingerprint(made->schema.described->descriptor());
  }
  made->schema.schema = std::make_shared<const MessageSchema>(std::move(schema));
  made->message = MessageTypeOf(made->schema);
  made->call = RawCallTypeOf(made->message);
  return made;
}

std::size_t BytesOf(const MessageSchema& schema) { return schema.type_name.size() + schema.descriptor_set.size(); }

// Types are never destroyed, because channels keep pointers to them and may outlive sessions. Therefore the number of
// types is limited, and the bytes of their descriptions, of which each takes several times its size.
const RunTimeTypes& TypesOf(const MessageSchema& schema) {
  static std::mutex mutex;
  static std::size_t count = 0;
  static std::size_t bytes = 0;
  static auto& by_name = *new std::map<std::string, std::vector<std::unique_ptr<RunTimeTypes>>, std::less<>>();
  const std::scoped_lock lock(mutex);
  if (const auto named = by_name.find(schema.type_name); named != by_name.end()) {
    for (const auto& one : named->second) {
      if (one->named == schema || *one->schema.schema == schema) return *one;
    }
  }
  auto made = MakeRunTimeTypes(schema);
  auto& of_name = by_name[schema.type_name];
  for (const auto& one : of_name) {  // The same type, but named with another fingerprint or with none.
    if (*one->schema.schema == *made->schema.schema) return *one;
  }
  if (count >= kMostRunTimeTypes || bytes + BytesOf(schema) > kMostRunTimeTypeBytes) {
    throw Error("Type " + schema.type_name + " is refused: this process has named " + std::to_string(count) +
                    " types at run time, with descriptions of " + std::to_string(bytes) + " bytes. At most " +
                    std::to_string(kMostRunTimeTypes) + " types with " + std::to_string(kMostRunTimeTypeBytes) +
                    " bytes can be named, because they are kept until the process ends.",
                {}, "Use one schema for each type, or pass on messages of unknown types in another process.");
  }
  ++count;
  bytes += BytesOf(schema);
  return *of_name.emplace_back(std::move(made));
}

std::string InHex(std::uint64_t number) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text(16, '0');
  for (std::size_t i = text.size(); i-- > 0; number >>= 4) text[i] = kDigits[number & 15];
  return text;
}

bool IsRaw(const TypeInfo& type) noexcept { return IsAnyType(type) || IsRunTimeType(type); }

// One object that all messages of a type share.
std::shared_ptr<const MessageSchema> SharedSchemaOf(const TypeInfo& type) {
  if (type.run_time != nullptr) return type.run_time->schema;
  if (IsAnyType(type)) return std::make_shared<const MessageSchema>();
  static std::mutex mutex;
  static auto& known = *new std::map<std::type_index, std::shared_ptr<const MessageSchema>>();
  const std::scoped_lock lock(mutex);
  auto& schema = known[type.cpp_type];
  if (!schema) schema = std::make_shared<const MessageSchema>(SchemaOf(type));
  return schema;
}

}  // namespace

const TypeInfo& RunTimeType(const MessageSchema& schema) { return TypesOf(schema).message; }
const TypeInfo& RunTimeCallType(const MessageSchema& schema) { return TypesOf(schema).call; }

std::string MisfitOf(const MessageSchema& theirs, const MessageSchema& ours) {
  return MisfitOf(theirs, RunTimeType(ours));
}

MessageSchema NamedSchema(const MessageSchema& schema) { return *TypesOf(schema).schema.schema; }

bool AreInterchangeable(const TypeInfo& one, const TypeInfo& other) noexcept {
  if (IsAnyType(one) || IsAnyType(other) || IsSameType(one, other)) return true;
  if (one.run_time == nullptr && other.run_time == nullptr) return false;
  return one.name == other.name && one.encoding == other.encoding &&
         (one.fingerprint == other.fingerprint || one.fingerprint == 0 || other.fingerprint == 0);
}

AnyMessage ConvertMessage(const AnyMessage& message, const TypeInfo& from, const TypeInfo& to) {
  if (IsRaw(from) && IsRaw(to)) {
    const auto& raw = *static_cast<const RawMessage*>(message.get());
    if (raw.schema) return message;
    return std::make_shared<const RawMessage>(RawMessage{SharedSchemaOf(IsAnyType(to) ? from : to), raw.data});
  }
  if (IsSameType(from, to)) return message;
  if (IsRaw(from)) return to.decode(static_cast<const RawMessage*>(message.get())->data);
  if (!IsRaw(to)) return nullptr;
  Payload data;
  try {
    data = from.encode(message);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
  if (data.owner == nullptr) return nullptr;
  return std::make_shared<const RawMessage>(RawMessage{SharedSchemaOf(from), std::move(data)});
}

std::string DescribeTypeFully(const TypeInfo& type) {
  const char* encoding = "not encoded";
  switch (type.encoding) {
    case Encoding::kNone: break;
    case Encoding::kProtobuf: encoding = "protobuf"; break;
    case Encoding::kCustom: encoding = "its own encoding"; break;
    case Encoding::kPlain: encoding = "a plain struct"; break;
  }
  const std::string fingerprint = type.fingerprint == 0 ? "no fingerprint" : "fingerprint " + InHex(type.fingerprint);
  return type.name + " (" + encoding + ", " + fingerprint + ")";
}

std::string DescriptorSetOf(const TypeInfo& type) {
  if (type.run_time != nullptr) return type.run_time->schema->descriptor_set;
  return type.descriptor_set == nullptr ? std::string() : type.descriptor_set();
}

const google::protobuf::Descriptor* DescriptorOf(const TypeInfo& type) {
  if (type.run_time != nullptr) {
    return type.run_time->described ? &type.run_time->described->descriptor() : nullptr;
  }
  return type.descriptor == nullptr ? nullptr : type.descriptor();
}

Payload OwnedPayload(const Payload& payload) {
  if (payload.owner != nullptr) return payload;
  auto copy = std::make_shared<std::string>();
  copy->reserve(payload.bytes.size());  // Throws if that is no possible size.
  copy->append(AsText(payload.bytes));
  const Bytes bytes = AsBytes(*copy);
  return {bytes, std::move(copy)};
}

}  // namespace hgros
