#include "messages/schema_text.hpp"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "messages/known_types.hpp"
#include "messages/message_reader.hpp"
#include "messages/message_text.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {

using google::protobuf::Descriptor;
using google::protobuf::EnumDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::OneofDescriptor;

namespace {

// A declaration at the top of a file: a message or an enum, with all that is declared in it.
struct Declared {
  const Descriptor* message = nullptr;
  const EnumDescriptor* values = nullptr;

  friend bool operator<(const Declared& a, const Declared& b) {
    return std::pair(a.message, a.values) < std::pair(b.message, b.values);
  }
};

const Descriptor* OutermostOf(const Descriptor* type) {
  while (type->containing_type() != nullptr) type = type->containing_type();
  return type;
}

// From the type to those that it needs. Not recursive, because a foreign schema may be a long chain.
std::vector<Declared> DeclarationsFor(const Descriptor& type) {
  std::vector<Declared> all{{OutermostOf(&type), nullptr}};
  std::set<Declared> known{all.front()};
  const auto note = [&](Declared one) {
    if (known.insert(one).second) all.push_back(one);
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].message == nullptr) continue;
    std::vector<const Descriptor*> inside{all[i].message};
    for (std::size_t k = 0; k < inside.size(); ++k) {
      const Descriptor& message = *inside[k];
      for (int n = 0; n < message.nested_type_count(); ++n) inside.push_back(message.nested_type(n));
      for (int f = 0; f < message.field_count(); ++f) {
        const FieldDescriptor& field = *message.field(f);
        if (field.message_type() != nullptr) note({OutermostOf(field.message_type()), nullptr});
        if (field.enum_type() == nullptr) continue;
        const Descriptor* around = field.enum_type()->containing_type();
        note(around != nullptr ? Declared{OutermostOf(around), nullptr} : Declared{nullptr, field.enum_type()});
      }
    }
  }
  std::ranges::reverse(all);
  return all;
}

// The name as it may be written inside `scope`.
std::string NameWithin(std::string_view name, std::string_view scope) {
  while (!scope.empty()) {
    if (name.size() > scope.size() && name.starts_with(scope) && name[scope.size()] == '.') {
      return std::string(name.substr(scope.size() + 1));
    }
    const std::size_t dot = scope.rfind('.');
    scope = dot == std::string_view::npos ? std::string_view() : scope.substr(0, dot);
  }
  return std::string(name);
}

bool IsOptional(const OneofDescriptor& oneof) { return oneof.field_count() == 1 && oneof.name().starts_with('_'); }

bool IsMapEntry(const Descriptor& nested) {
  const Descriptor* around = nested.containing_type();
  for (int i = 0; around != nullptr && i < around->field_count(); ++i) {
    if (around->field(i)->message_type() == &nested) return IsMapField(*around->field(i));
  }
  return false;
}

std::string KindWithin(const FieldDescriptor& field, std::string_view scope) {
  if (IsMapField(field)) {
    const Descriptor& entry = *field.message_type();
    return "map<" + KindWithin(*entry.FindFieldByNumber(1), scope) + ", " +
           KindWithin(*entry.FindFieldByNumber(2), scope) + ">";
  }
  if (field.message_type() != nullptr) return NameWithin(field.message_type()->full_name(), scope);
  if (field.enum_type() != nullptr) return NameWithin(field.enum_type()->full_name(), scope);
  return field.type_name();
}

void AppendEnum(std::string& out, const EnumDescriptor& type, std::size_t indent) {
  const std::string before(indent, ' ');
  out += before + "enum " + type.name() + " {\n";
  for (int i = 0; i < type.value_count(); ++i) {
    out += fmt::format("{}  {} = {};\n", before, type.value(i)->name(), type.value(i)->number());
  }
  out += before + "}\n";
}

void AppendField(std::string& out, const FieldDescriptor& field, std::size_t indent) {
  const OneofDescriptor* oneof = field.containing_oneof();
  out.append(indent, ' ');
  if (field.is_repeated() && !IsMapField(field)) out += "repeated ";
  if (field.is_required()) out += "required ";
  if (oneof != nullptr && IsOptional(*oneof)) out += "optional ";
  out += fmt::format("{} {} = {};\n", KindWithin(field, field.containing_type()->full_name()), field.name(),
                     field.number());
}

void AppendDeclaration(std::string& out, const Descriptor& type, std::size_t indent) {
  const std::string before(indent, ' ');
  out += before + "message " + type.name() + " {\n";
  for (int i = 0; i < type.enum_type_count(); ++i) AppendEnum(out, *type.enum_type(i), indent + 2);
  for (int i = 0; i < type.nested_type_count(); ++i) {
    if (!IsMapEntry(*type.nested_type(i))) AppendDeclaration(out, *type.nested_type(i), indent + 2);
  }
  std::set<const OneofDescriptor*> written;
  for (int i = 0; i < type.field_count(); ++i) {
    const OneofDescriptor* oneof = type.field(i)->containing_oneof();
    if (oneof == nullptr || IsOptional(*oneof)) {
      AppendField(out, *type.field(i), indent + 2);
    } else if (written.insert(oneof).second) {
      out += before + "  oneof " + oneof->name() + " {\n";
      for (int k = 0; k < oneof->field_count(); ++k) AppendField(out, *oneof->field(k), indent + 4);
      out += before + "  }\n";
    }
  }
  out += before + "}\n";
}

void AppendFields(std::vector<const FieldDescriptor*>& fields, const Descriptor& type) {
  for (int i = 0; i < type.nested_type_count(); ++i) {
    if (!IsMapEntry(*type.nested_type(i))) AppendFields(fields, *type.nested_type(i));
  }
  for (int i = 0; i < type.field_count(); ++i) fields.push_back(type.field(i));
}

// Writes the template. Bounded in depth and in lines: a foreign schema may have many paths through few types.
class TemplateWriter {
 public:
  std::string Write(const Descriptor& type) {
    AppendMessage(type, 0);
    return std::move(out_);
  }

 private:
  void AppendMessage(const Descriptor& type, std::size_t indent);
  // What follows "name:" or "-", with the line break.
  void AppendValue(const FieldDescriptor& field, std::size_t indent);
  [[nodiscard]] static std::string Example(const FieldDescriptor& field);
  [[nodiscard]] bool Expands(const Descriptor& type) const {
    constexpr std::size_t kDeepest = 16;
    constexpr int kMostLines = 2000;
    return type.field_count() > 0 && lines_ < kMostLines && open_.size() < kDeepest &&
           std::ranges::find(open_, &type) == open_.end();
  }

  std::string out_;
  std::vector<const Descriptor*> open_;
  int lines_ = 0;
};

std::string TemplateWriter::Example(const FieldDescriptor& field) {
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_BOOL: return "false";
    case FieldDescriptor::CPPTYPE_FLOAT:
    case FieldDescriptor::CPPTYPE_DOUBLE: return "0.0";
    case FieldDescriptor::CPPTYPE_STRING: return field.type() == FieldDescriptor::TYPE_BYTES ? "!!binary \"\"" : "\"\"";
    case FieldDescriptor::CPPTYPE_ENUM: {
      constexpr int kMost = 10;
      const EnumDescriptor& type = *field.enum_type();
      std::string text = NameText(type.value(0)->name());
      for (int i = 1; i < type.value_count() && i < kMost; ++i) {
        text += (i == 1 ? "  # or " : ", ") + NameText(type.value(i)->name());
      }
      return text + (type.value_count() > kMost ? ", ..." : "");
    }
    case FieldDescriptor::CPPTYPE_MESSAGE:
      switch (KnownTypeOf(*field.message_type())) {
        case KnownType::kTimestamp: return "now";
        case KnownType::kDuration: return "0s";
        case KnownType::kNone: return "{}";
      }
      return "{}";
    default: return "0";
  }
}

void TemplateWriter::AppendValue(const FieldDescriptor& field, std::size_t indent) {
  const Descriptor* type = field.message_type();
  if (type != nullptr && KnownTypeOf(*type) == KnownType::kNone && Expands(*type)) {
    out_ += '\n';
    AppendMessage(*type, indent);
  } else {
    out_ += " " + Example(field) + "\n";
  }
}

void TemplateWriter::AppendMessage(const Descriptor& type, std::size_t indent) {
  open_.push_back(&type);
  const std::string before(indent, ' ');
  if (type.field_count() == 0) out_ += before + "{}\n";
  std::set<const OneofDescriptor*> chosen;
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    ++lines_;
    const OneofDescriptor* oneof = field.containing_oneof();
    if (oneof != nullptr && !chosen.insert(oneof).second) {
      out_ += before + "# " + field.name() + ": instead, a " + KindOf(field) + "\n";
      continue;
    }
    out_ += before + field.name() + ":";
    if (!field.is_repeated()) {
      AppendValue(field, indent + 2);
    } else if (IsMapField(field)) {
      out_ += " {}  # " + KindOf(field) + "\n";
    } else if (field.message_type() != nullptr && KnownTypeOf(*field.message_type()) == KnownType::kNone &&
               Expands(*field.message_type())) {
      out_ += '\n';
      const std::size_t begin = out_.size();
      AppendMessage(*field.message_type(), indent + 2);
      out_[begin + indent] = '-';
    } else {
      out_ += " []  # of " + KindOf(field) + "\n";
    }
  }
  open_.pop_back();
}

}  // namespace

std::string ProtoText(const Descriptor& type) {
  std::string out;
  for (const Declared& one : DeclarationsFor(type)) {
    const google::protobuf::FileDescriptor& file = one.message != nullptr ? *one.message->file() : *one.values->file();
    if (!out.empty()) out += '\n';
    out += "// " + (one.message != nullptr ? one.message->full_name() : one.values->full_name()) + ", from " +
           Visible(file.name()) + "\n";
    if (one.message != nullptr) {
      AppendDeclaration(out, *one.message, 0);
    } else {
      AppendEnum(out, *one.values, 0);
    }
  }
  return out;
}

std::string TemplateText(const Descriptor& type) { return TemplateWriter().Write(type); }

std::vector<const FieldDescriptor*> FieldsOf(const Descriptor& type) {
  std::vector<const FieldDescriptor*> fields;
  for (const Declared& one : DeclarationsFor(type)) {
    if (one.message != nullptr) AppendFields(fields, *one.message);
  }
  return fields;
}

std::string KindOf(const FieldDescriptor& field) { return KindWithin(field, {}); }

}  // namespace hgros::cli
