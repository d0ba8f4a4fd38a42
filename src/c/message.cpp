#include "hgros/c/message.h"

#include <google/protobuf/descriptor.h>

#include <atomic>

#include "c/raw.hpp"
#include "hgros/codec/run_time_type.hpp"
#include "hgros/codec/schema.hpp"

namespace hgros::c {
namespace {

std::atomic<std::uint64_t> leases{0};

// Checked here once, so that a wrong description is found where it is given.
std::unique_ptr<hgros_schema> NewSchema(const MessageSchema& schema) {
  return std::make_unique<hgros_schema>(hgros_schema{RunTimeType(schema).run_time->schema});
}

}  // namespace

void CountLease() noexcept { leases.fetch_add(1, std::memory_order_relaxed); }

std::unique_ptr<hgros_message> NewLease(std::shared_ptr<const RawMessage> raw, const MessageInfo& info) {
  auto lease = std::make_unique<hgros_message>(std::move(raw), info);
  CountLease();
  return lease;
}

}  // namespace hgros::c

namespace c = hgros::c;

hgros_status hgros_schema_create(const char* type_name, int32_t encoding, uint64_t fingerprint,
                                 const void* descriptor_set, size_t descriptor_set_size, hgros_schema** schema) {
  return c::Creating(schema, [&] {
    hgros::MessageSchema made{std::string(c::Text(type_name, "type_name")), hgros::Encoding::kNone, fingerprint, {}};
    if (encoding < HGROS_ENCODING_PROTOBUF || encoding > HGROS_ENCODING_PLAIN) {
      throw c::InvalidArgument("There is no encoding " + std::to_string(encoding) +
                               ". Use HGROS_ENCODING_PROTOBUF, "
                               "HGROS_ENCODING_CUSTOM or HGROS_ENCODING_PLAIN.");
    }
    made.encoding = static_cast<hgros::Encoding>(encoding);
    made.descriptor_set = hgros::AsText(c::Borrowed(descriptor_set, descriptor_set_size).bytes);
    return c::NewSchema(made);
  });
}

hgros_status hgros_schema_known(const char* type_name, hgros_schema** schema) {
  if (schema != nullptr) *schema = nullptr;
  return c::Guarded([&] {
    const std::string name(c::Text(type_name, "type_name"));
    auto& place = c::Given(schema, "the place for the result");
    const auto* const type = google::protobuf::DescriptorPool::generated_pool()->FindMessageTypeByName(name);
    if (type == nullptr) {
      return c::Fail(HGROS_NOT_FOUND, "No message type " + name +
                                          " comes with the library. For a type of your own, pass "
                                          "its descriptor set to hgros_schema_create().");
    }
    place = c::NewSchema({name, hgros::Encoding::kProtobuf, 0, hgros::DescriptorSet(*type)}).release();
    return hgros_status{HGROS_OK};
  });
}

void hgros_schema_free(hgros_schema* schema) { delete schema; }

const char* hgros_schema_type_name(const hgros_schema* schema) {
  return schema == nullptr ? nullptr : schema->schema->type_name.c_str();
}
int32_t hgros_schema_encoding(const hgros_schema* schema) {
  return schema == nullptr ? HGROS_ENCODING_NONE : static_cast<int32_t>(schema->schema->encoding);
}
uint64_t hgros_schema_fingerprint(const hgros_schema* schema) {
  return schema == nullptr ? 0 : schema->schema->fingerprint;
}
const void* hgros_schema_descriptor_set(const hgros_schema* schema, size_t* size) {
  const std::string_view set = schema == nullptr ? std::string_view() : schema->schema->descriptor_set;
  if (size != nullptr) *size = set.size();
  return set.empty() ? nullptr : set.data();
}

const void* hgros_message_data(const hgros_message* message, size_t* size) {
  const hgros::Bytes bytes = message == nullptr ? hgros::Bytes() : message->raw->data.bytes;
  if (size != nullptr) *size = bytes.size();
  return bytes.data();
}

const hgros_schema* hgros_message_schema(const hgros_message* message) {
  return message == nullptr ? nullptr : &message->schema;
}

hgros_status hgros_message_get_info(const hgros_message* message, hgros_message_info* info) {
  return c::Guarded([&] {
    const hgros::MessageInfo& from = c::Given(message, "message").info;
    hgros_message_info filled{};
    filled.publisher = from.id.publisher;
    filled.incarnation = from.id.incarnation;
    filled.sequence = from.id.sequence;
    filled.key = from.key;
    filled.publish_monotonic_ns = from.publish_monotonic_ns;
    filled.publish_time_ns = from.publish_time_ns;
    filled.remote = from.remote ? 1 : 0;
    c::FillIn(info, filled);
  });
}

hgros_status hgros_message_keep(const hgros_message* message, hgros_message** kept) {
  return c::Creating(kept, [&] {
    const hgros_message& of = c::Given(message, "message");
    return c::NewLease(of.raw, of.info);
  });
}

void hgros_message_free(hgros_message* message) {
  if (message == nullptr) return;
  delete message;
  c::leases.fetch_sub(1, std::memory_order_relaxed);
}

uint64_t hgros_message_leases(void) { return c::leases.load(std::memory_order_relaxed); }
