#include "messages/csv.hpp"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <optional>

#include "messages/known_types.hpp"
#include "messages/message_text.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kMostCsvColumns = 1000;  // More are one cell of JSON.

}  // namespace

Csv::Csv(const google::protobuf::Descriptor& type, const std::vector<std::string>& paths) {
  if (paths.empty()) AddColumns(type, "", {});
  for (const std::string& path : paths) AddColumns(type, path, {});
}

void Csv::AddColumns(const google::protobuf::Descriptor& root, const std::string& path,
                     std::vector<const google::protobuf::Descriptor*> around) {
  FieldPath place = FieldPath::Parse(path, root);
  const google::protobuf::FieldDescriptor* field = place.field();
  const google::protobuf::Descriptor* type = field == nullptr ? &root : place.list() ? nullptr : field->message_type();
  const bool contains_itself = std::ranges::find(around, type) != around.end();
  if (type == nullptr || contains_itself ||
      names_.size() + static_cast<std::size_t>(type->field_count()) > kMostCsvColumns ||
      KnownTypeOf(*type) != KnownType::kNone) {
    names_.push_back(path);
    columns_.push_back(std::move(place));
    return;
  }
  around.push_back(type);
  for (int i = 0; i < type->field_count(); ++i) {
    AddColumns(root, (path.empty() ? "" : path + ".") + type->field(i)->name(), around);
  }
}

std::string Csv::Header() const {
  std::string header;
  for (const std::string& name : names_) header += (header.empty() ? "" : ",") + CsvCell(name);
  return header;
}

std::string Csv::Row(const google::protobuf::Message& message) const {
  std::string row;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (i > 0) row += ',';
    if (const std::optional<FieldRef> place = columns_[i].Find(message)) row += CsvCell(Visible(PlainText(*place)));
  }
  return row;
}

std::string CsvCell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace hgros::cli
