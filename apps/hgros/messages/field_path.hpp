#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace google::protobuf {
class Descriptor;
class FieldDescriptor;
class Message;
}  // namespace google::protobuf

namespace hgros::cli {

/// A place in a message: all of it (no field), a field, or one item of a repeated field.
struct FieldRef {
  const google::protobuf::Message* message = nullptr;
  const google::protobuf::FieldDescriptor* field = nullptr;
  int index = -1;  ///< -1: the field itself, if repeated all of its items.

  [[nodiscard]] bool list() const noexcept;
  /// The message at this place; null if it is something else.
  [[nodiscard]] const google::protobuf::Message* AsMessage() const;
};

/// Names a place in the messages of one type: "pose.position.x", "transforms[0].child_frame_id", "ranges".
class FieldPath {
 public:
  /// Throws UsageError if `text` is not a path in any type.
  static void RequireForm(std::string_view text);
  /// An empty path is the whole message. Throws UsageError that names the wrong part and the nearest field.
  [[nodiscard]] static FieldPath Parse(std::string_view text, const google::protobuf::Descriptor& type);

  /// Empty if a list is too short, or a message on the way is not set.
  [[nodiscard]] std::optional<FieldRef> Find(const google::protobuf::Message& message) const;
  /// The last field; null for the whole message.
  [[nodiscard]] const google::protobuf::FieldDescriptor* field() const noexcept;
  /// Whether it names a list.
  [[nodiscard]] bool list() const noexcept;

 private:
  struct Step {
    const google::protobuf::FieldDescriptor* field;
    int index;  // -1: none.
  };
  std::vector<Step> steps_;
};

/// Throws UsageError: `type` has no field `name`, with the nearest one.
const google::protobuf::FieldDescriptor& RequireField(const google::protobuf::Descriptor& type, std::string_view name);

}  // namespace hgros::cli
