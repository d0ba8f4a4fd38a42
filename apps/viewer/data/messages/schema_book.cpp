#include "viewer/data/messages/schema_book.hpp"

namespace hgros::viewer {

std::shared_ptr<const DynamicSchema> SchemaBook::Find(const std::shared_ptr<const MessageSchema>& schema) {
  auto found = entries_.find(schema.get());
  if (found == entries_.end()) {
    if (entries_.size() >= kMost) entries_.clear();
    Entry entry{schema, nullptr, {}};
    if (schema->encoding != Encoding::kProtobuf) {
      entry.fault = "Messages of " + (schema->type_name.empty() ? "an unknown type" : "\"" + schema->type_name + "\"") +
                    " are not protobuf: only their size is known.";
    } else if (schema->descriptor_set.empty()) {
      entry.fault = "The publisher of \"" + schema->type_name + "\" does not send its schema: only the size is known.";
    } else {
      entry.type = DynamicSchema::Build(*schema, entry.fault);
    }
    found = entries_.emplace(schema.get(), std::move(entry)).first;
  }
  fault_ = found->second.fault;
  return found->second.type;
}

}  // namespace hgros::viewer
