#include "hgros/codec/bulk_field.hpp"

#include <google/protobuf/descriptor.h>

#include <string>
#include <vector>

#include "hgros/base/error.hpp"

namespace hgros::codec {
namespace {

using google::protobuf::FieldDescriptor;

// A later member of a oneof clears an earlier one, which cannot be seen if the fields are parsed separately. A required
// field would be missing from one of the two parts.
bool CanBeBulk(const FieldDescriptor& field) {
  return field.type() == FieldDescriptor::TYPE_BYTES && !field.is_repeated() && !field.is_required() &&
         field.real_containing_oneof() == nullptr;
}

}  // namespace

const FieldDescriptor& FindBulkField(const google::protobuf::Descriptor& type, int number) {
  const std::string bulk = "Bulk<" + type.full_name() + ">";
  std::vector<const FieldDescriptor*> found;
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    if (CanBeBulk(field) && (number == 0 || field.number() == number)) found.push_back(&field);
  }
  if (found.size() == 1) return *found.front();
  if (number != 0) {
    throw Error("hgros::BulkField says that field " + std::to_string(number) + " of " + type.full_name() +
                    " is the large one of " + bulk + ", but the schema has no such field of bytes.",
                {}, "Name a field of type bytes that is neither repeated nor required nor in a oneof.");
  }
  if (found.empty()) {
    throw Error(bulk + " needs a field of type bytes, and " + type.full_name() +
                    " has none that is neither repeated nor required nor in a oneof.",
                {}, "Send " + type.full_name() + " itself, or give its schema a field of type bytes.");
  }
  std::string names;
  for (const FieldDescriptor* field : found) names += (names.empty() ? "" : ", ") + field->name();
  throw Error(bulk + " needs to know which field is the large one: " + names + " are all of type bytes.", {},
              "Specialize hgros::BulkField for the class, with the number of one of them.");
}

}  // namespace hgros::codec
