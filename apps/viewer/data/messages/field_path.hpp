#pragma once

#include <google/protobuf/message.h>

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hgros::viewer {

/// The path of a number in messages of one type, such as "pose.position.x", "ranges[3]" or "joints[2].position". Thread
/// safety: several threads may read at once.
class FieldPath {
 public:
  /// None if messages of `type` have no number at that path; then `fault` is a sentence that says why. The type must
  /// outlive the path.
  [[nodiscard]] static std::optional<FieldPath> Parse(std::string_view text, const google::protobuf::Descriptor& type,
                                                      std::string& fault);

  /// Reads the number: 0 or 1 of a bool, the value of an enum, seconds of timestamps and durations. None if the message
  /// does not have that element or a message on the path. The message must have the path's type.
  [[nodiscard]] std::optional<double> Read(const google::protobuf::Message& message) const;

 private:
  struct Step {
    const google::protobuf::FieldDescriptor* field;
    int index = -1;  ///< Index in a repeated field.
  };
  std::vector<Step> steps_;
};

/// All paths of numbers in messages of `type`: at most `most`, at most eight steps deep, recursive messages once, and
/// only the first element of repeated fields.
[[nodiscard]] std::vector<std::string> NumberPaths(const google::protobuf::Descriptor& type, std::size_t most);

}  // namespace hgros::viewer
