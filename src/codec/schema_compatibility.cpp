#include "hgros/codec/schema_compatibility.hpp"

#include <google/protobuf/descriptor.h>

#include <set>
#include <utility>

#include "codec/foreign_schema.hpp"

namespace hgros {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

constexpr std::size_t kMaxComparedPairs = 10'000;
constexpr std::size_t kMaxNotes = 16;

enum class Family { kVarint, kZigzag, kFixed32, kFixed64, kFloat, kDouble, kBytes, kMessage, kGroup };

Family FamilyOf(const FieldDescriptor& field) {
  switch (field.type()) {
    case FieldDescriptor::TYPE_INT32:
    case FieldDescriptor::TYPE_INT64:
    case FieldDescriptor::TYPE_UINT32:
    case FieldDescriptor::TYPE_UINT64:
    case FieldDescriptor::TYPE_BOOL:
    case FieldDescriptor::TYPE_ENUM: return Family::kVarint;
    case FieldDescriptor::TYPE_SINT32:
    case FieldDescriptor::TYPE_SINT64: return Family::kZigzag;
    case FieldDescriptor::TYPE_FIXED32:
    case FieldDescriptor::TYPE_SFIXED32: return Family::kFixed32;
    case FieldDescriptor::TYPE_FIXED64:
    case FieldDescriptor::TYPE_SFIXED64: return Family::kFixed64;
    case FieldDescriptor::TYPE_FLOAT: return Family::kFloat;
    case FieldDescriptor::TYPE_DOUBLE: return Family::kDouble;
    case FieldDescriptor::TYPE_STRING:
    case FieldDescriptor::TYPE_BYTES: return Family::kBytes;
    case FieldDescriptor::TYPE_MESSAGE: return Family::kMessage;
    case FieldDescriptor::TYPE_GROUP: return Family::kGroup;
  }
  return Family::kGroup;
}

std::string Describe(const FieldDescriptor& field) {
  std::string text = field.is_repeated() ? "repeated " : (field.is_required() ? "required " : "");
  if (field.message_type() != nullptr) {
    text += field.message_type()->full_name();
  } else if (field.enum_type() != nullptr) {
    text += field.enum_type()->full_name();
  } else {
    text += field.type_name();
  }
  return text + " " + field.name();
}

std::string Place(const Descriptor& message, int number) {
  return "Field " + std::to_string(number) + " of " + message.full_name();
}

/// The reason why a field that both sides know cannot be read, or an empty text.
std::string FieldFault(const FieldDescriptor& theirs, const FieldDescriptor& ours) {
  const std::string pair = " is \"" + Describe(theirs) + "\" there and \"" + Describe(ours) + "\" here";
  const std::string place = Place(*ours.containing_type(), ours.number());
  if (FamilyOf(theirs) != FamilyOf(ours)) return place + pair + ": these are written differently.";
  if (theirs.is_repeated() != ours.is_repeated()) return place + pair + ": one side sends a list, the other one value.";
  if (ours.is_required() && !theirs.is_required()) return place + pair + ": it may be missing.";
  return {};
}

SchemaVerdict Incompatible(std::string reason) { return {false, std::move(reason), {}}; }

SchemaVerdict Compare(const Descriptor& their_root, const Descriptor& our_root) {
  using Pair = std::pair<const Descriptor*, const Descriptor*>;
  SchemaVerdict verdict{true, {}, {}};
  std::set<Pair> seen{{&their_root, &our_root}};
  std::vector<Pair> open{{&their_root, &our_root}};
  while (!open.empty()) {
    const auto [theirs, ours] = open.back();
    open.pop_back();
    for (int i = 0; i < ours->field_count(); ++i) {
      const FieldDescriptor& our_field = *ours->field(i);
      const FieldDescriptor* const their_field = theirs->FindFieldByNumber(our_field.number());
      if (their_field == nullptr) {
        if (!our_field.is_required()) continue;
        return Incompatible(Place(*ours, our_field.number()) + " is \"" + Describe(our_field) +
                            "\" here and unknown there.");
      }
      std::string fault = FieldFault(*their_field, our_field);
      if (!fault.empty()) return Incompatible(std::move(fault));
      if (their_field->name() != our_field.name() && verdict.notes.size() < kMaxNotes) {
        verdict.notes.push_back(Place(*ours, our_field.number()) + " is named \"" + their_field->name() +
                                "\" there and \"" + our_field.name() + "\" here.");
      }
      if (our_field.message_type() == nullptr) continue;
      const Pair next{their_field->message_type(), our_field.message_type()};
      if (seen.size() >= kMaxComparedPairs) return Incompatible("The schemas are too large to be compared.");
      if (seen.insert(next).second) open.push_back(next);
    }
  }
  return verdict;
}

}  // namespace

SchemaVerdict CheckSchemas(std::string_view their_descriptor_set, const std::string& their_type_name,
                           const Descriptor& ours) {
  if (their_type_name != ours.full_name()) {
    return Incompatible("The type is " + their_type_name + " there and " + ours.full_name() + " here.");
  }
  const ForeignSchema theirs = BuildForeignSchema(their_descriptor_set, their_type_name, EnumValues::kLeftOut);
  if (theirs.type == nullptr) return Incompatible("The peer's schema " + theirs.fault);
  return Compare(*theirs.type, ours);
}

}  // namespace hgros
