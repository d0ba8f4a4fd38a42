#include "viewer/data/messages/message_tree.hpp"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace hgros::viewer {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

constexpr int kMaxDepth = 32;

template <class T>
std::string Shortest(T number) {
  std::array<char, 64> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number);
  return {text.data(), end};
}

/// Writes the rows of one message.
class Writer {
 public:
  explicit Writer(const TreeView& view) : view_(view) {}

  void Add(const Message& message, const std::string& before, int depth) {
    const auto& type = *message.GetDescriptor();
    for (int i = 0; i < type.field_count() && !full_; ++i) {
      const FieldDescriptor& field = *type.field(i);
      field.is_repeated() ? AddList(message, field, before, depth) : AddField(message, field, -1, before, depth);
    }
  }
  [[nodiscard]] std::vector<TreeRow> Take() { return std::move(rows_); }

 private:
  // Null if there is no space left.
  TreeRow* AddRow(std::string path, std::string name, int depth) {
    if (rows_.size() < view_.most_rows) {
      TreeRow& row = rows_.emplace_back();
      row.path = std::move(path);
      row.name = std::move(name);
      row.depth = depth;
      return &row;
    }
    if (!full_) rows_.push_back({"", "", "more rows are not shown", depth, false, false, false});
    full_ = true;
    return nullptr;
  }

  void AddList(const Message& message, const FieldDescriptor& field, const std::string& before, int depth) {
    const std::string path = before + field.name();
    const int size = message.GetReflection()->FieldSize(message, &field);
    TreeRow* const row = AddRow(path, field.name(), depth);
    if (row == nullptr) return;
    row->value = std::to_string(size) + (size == 1 ? " element" : " elements");
    row->folds = size > 0;
    row->opened = row->folds && view_.opened.contains(path);
    if (!row->opened) return;
    const int shown = static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(size), view_.most_elements));
    for (int i = 0; i < shown && !full_; ++i) AddField(message, field, i, before, depth + 1);
    if (shown == size || full_) return;
    if (TreeRow* const more = AddRow("", "", depth + 1)) more->value = std::to_string(size - shown) + " more";
  }

  void AddField(const Message& message, const FieldDescriptor& field, int index, const std::string& before, int depth) {
    const std::string element = index < 0 ? std::string() : "[" + std::to_string(index) + "]";
    const std::string path = before + field.name() + element;
    TreeRow* const row = AddRow(path, index < 0 ? field.name() : element, depth);
    if (row == nullptr) return;
    const Reflection& r = *message.GetReflection();
    if (field.cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) {
      row->value = Text(message, field, index);
      row->number = field.cpp_type() != FieldDescriptor::CPPTYPE_STRING;
      return;
    }
    if (index < 0 && !r.HasField(message, &field)) {
      row->value = "not set";
      return;
    }
    const Message& inner = index < 0 ? r.GetMessage(message, &field) : r.GetRepeatedMessage(message, &field, index);
    row->value = field.message_type()->name();
    row->folds = field.message_type()->field_count() > 0 && depth < kMaxDepth;
    row->opened = row->folds && view_.opened.contains(path);
    if (row->opened) Add(inner, path + ".", depth + 1);
  }

  std::string Text(const Message& message, const FieldDescriptor& field, int index) const {
    const Reflection& r = *message.GetReflection();
    const bool one = index < 0;
    switch (field.cpp_type()) {
      case FieldDescriptor::CPPTYPE_INT32:
        return Shortest(one ? r.GetInt32(message, &field) : r.GetRepeatedInt32(message, &field, index));
      case FieldDescriptor::CPPTYPE_INT64:
        return Shortest(one ? r.GetInt64(message, &field) : r.GetRepeatedInt64(message, &field, index));
      case FieldDescriptor::CPPTYPE_UINT32:
        return Shortest(one ? r.GetUInt32(message, &field) : r.GetRepeatedUInt32(message, &field, index));
      case FieldDescriptor::CPPTYPE_UINT64:
        return Shortest(one ? r.GetUInt64(message, &field) : r.GetRepeatedUInt64(message, &field, index));
      case FieldDescriptor::CPPTYPE_DOUBLE:
        return Shortest(one ? r.GetDouble(message, &field) : r.GetRepeatedDouble(message, &field, index));
      case FieldDescriptor::CPPTYPE_FLOAT:
        return Shortest(one ? r.GetFloat(message, &field) : r.GetRepeatedFloat(message, &field, index));
      case FieldDescriptor::CPPTYPE_BOOL:
        return (one ? r.GetBool(message, &field) : r.GetRepeatedBool(message, &field, index)) ? "true" : "false";
      case FieldDescriptor::CPPTYPE_ENUM: {
        const int number = one ? r.GetEnumValue(message, &field) : r.GetRepeatedEnumValue(message, &field, index);
        const auto* const value = field.enum_type()->FindValueByNumber(number);
        return value == nullptr ? std::to_string(number) : value->name() + " (" + std::to_string(number) + ")";
      }
      case FieldDescriptor::CPPTYPE_STRING: {
        std::string room;
        const std::string& text = one ? r.GetStringReference(message, &field, &room)
                                      : r.GetRepeatedStringReference(message, &field, index, &room);
        if (field.type() == FieldDescriptor::TYPE_BYTES) return std::to_string(text.size()) + " bytes";
        return Readable(text);
      }
      case FieldDescriptor::CPPTYPE_MESSAGE: break;
    }
    return {};
  }

  [[nodiscard]] std::string Readable(const std::string& text) const {
    std::string readable = text.substr(0, view_.most_text);
    for (char& c : readable) {
      if (static_cast<unsigned char>(c) < 0x20 || c == '\x7f') c = '?';
    }
    if (text.size() > readable.size()) readable += "... (" + std::to_string(text.size()) + " bytes)";
    return readable;
  }

  const TreeView& view_;
  std::vector<TreeRow> rows_;
  bool full_ = false;
};

}  // namespace

std::vector<TreeRow> RowsOf(const Message& message, const TreeView& view) {
  Writer writer(view);
  writer.Add(message, {}, 0);
  return writer.Take();
}

}  // namespace hgros::viewer
