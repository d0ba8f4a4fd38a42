#pragma once

#include <google/protobuf/message.h>

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hgros::viewer {

/// The place of a number in messages of one type, such as "pose.position.x", "ranges[3]" or "joints[2].position".
/// Thread safety: as a value; reading is const.
class FieldPath {
 public:
  /// Nothing if messages of `type` have no number at that place; `fault` then says why, in a sentence. The type
  /// outlives the path.
  [[nodiscard]] static std::optional<FieldPath> Parse(std::string_view text, const google::protobuf::Descriptor& type,
                                                      std::string& fault);

  /// The number: of bool 0 or 1, of enums the value, of timestamps and durations seconds. Nothing if the message, which
  /// is of the path's type, has no element with that index, or no message on the way.
  [[nodiscard]] std::optional<double> Read(const google::protobuf::Message& message) const;

 private:
  struct Step {
    const google::protobuf::FieldDescriptor* field;
    int index = -1;  ///< Of a repeated field.
  };
  std::vector<Step> steps_;
};

/// All places of numbers in messages of `type`, those of a message in itself once, no deeper than eight steps and at
/// most `most`; of repeated fields the first element.
[[nodiscard]] std::vector<std::string> NumberPaths(const google::protobuf::Descriptor& type, std::size_t most);

}  // namespace hgros::viewer
