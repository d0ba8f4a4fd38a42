#include "hgros/codec/dynamic_schema.hpp"

#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/stubs/logging.h>

#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "codec/foreign_schema.hpp"
#include "codec/parsed_memory.hpp"

namespace hgros {

struct DynamicSchema::Parts {
  ForeignSchema schema;
  google::protobuf::DynamicMessageFactory factory;
  const google::protobuf::Message* prototype = nullptr;
  std::optional<ParsedMemory> memory;
};

DynamicSchema::DynamicSchema(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
DynamicSchema::~DynamicSchema() = default;

std::shared_ptr<const DynamicSchema> DynamicSchema::Build(const MessageSchema& schema, std::string& fault) {
  if (schema.encoding != Encoding::kProtobuf) {
    fault = "Messages of " + schema.type_name + " are not protobuf.";
    return nullptr;
  }
  auto parts = std::make_unique<Parts>();
  parts->schema = BuildForeignSchema(schema.descriptor_set, schema.type_name, EnumValues::kKept);
  if (parts->schema.type == nullptr) {
    fault = "The publisher's schema " + parts->schema.fault;
    return nullptr;
  }
  parts->prototype = parts->factory.GetPrototype(parts->schema.type);
  parts->memory.emplace(*parts->schema.type, parts->factory);
  return std::shared_ptr<const DynamicSchema>(new DynamicSchema(std::move(parts)));
}

const google::protobuf::Descriptor& DynamicSchema::descriptor() const noexcept { return *parts_->schema.type; }

std::unique_ptr<google::protobuf::Message> DynamicSchema::Read(Bytes bytes, std::size_t most_memory_bytes) const {
  std::string fault;
  return Read(bytes, fault, most_memory_bytes);
}

std::unique_ptr<google::protobuf::Message> DynamicSchema::Read(Bytes bytes, std::string& fault,
                                                               std::size_t most_memory_bytes) const {
  constexpr std::size_t kMostBytes = std::numeric_limits<int>::max();
  if (bytes.size() > kMostBytes) {
    fault = "It has " + std::to_string(bytes.size()) + " bytes, more than " + std::to_string(kMostBytes) + ".";
    return nullptr;
  }
  if (!parts_->memory->Fits(bytes, most_memory_bytes)) {
    fault = "Its " + std::to_string(bytes.size()) + " bytes are estimated to take more than " +
            std::to_string(most_memory_bytes) + " bytes of memory beyond their own size.";
    return nullptr;
  }
  const google::protobuf::LogSilencer silence;  // Protobuf would log every string that is not UTF-8.
  std::unique_ptr<google::protobuf::Message> message(parts_->prototype->New());
  if (message->ParsePartialFromArray(bytes.data(), static_cast<int>(bytes.size()))) return message;
  fault = "Its bytes do not parse.";
  return nullptr;
}

}  // namespace hgros
