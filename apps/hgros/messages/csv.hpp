#pragma once

#include <string>
#include <vector>

#include "messages/field_path.hpp"

namespace hgros::cli {

/// One column for each value of a message type: the fields of nested messages have columns of their own, a list is one
/// cell of JSON. Texts are visible.
class Csv {
 public:
  /// The columns of these places, or of the whole message if there are none.
  Csv(const google::protobuf::Descriptor& type, const std::vector<std::string>& paths);

  [[nodiscard]] std::string Header() const;
  [[nodiscard]] std::string Row(const google::protobuf::Message& message) const;

 private:
  // `around`: the types that contain this field.
  void AddColumns(const google::protobuf::Descriptor& root, const std::string& path,
                  std::vector<const google::protobuf::Descriptor*> around);

  std::vector<std::string> names_;
  std::vector<FieldPath> columns_;
};

/// A cell with quotes if it needs them (RFC 4180).
[[nodiscard]] std::string CsvCell(std::string_view text);

}  // namespace hgros::cli
