#pragma once

#include <memory>
#include <string_view>

namespace google::protobuf {
class Descriptor;
class Message;
}  // namespace google::protobuf

namespace hgros::cli {

/// A condition on the messages of one type, such as `pose.position.x > 1.5 && (level == "ERROR" || size(names) >= 3)`.
///
/// Values: fields (as FieldPath), numbers, texts in double or single quotes, true, false, names of an enum's values in
/// quotes, and size(LIST), also of a text. A field alone is true unless it is false, 0 or empty. Comparisons: == != <
/// <= > >=, and =~ with a regular expression. They are joined by &&, || and !, and grouped by parentheses. A comparison
/// with a field that is not set, or an item that is not there, is false.
class Filter {
 public:
  /// Throws UsageError that names the place of the fault.
  Filter(std::string_view text, const google::protobuf::Descriptor& type);
  Filter(Filter&&) noexcept;
  Filter& operator=(Filter&&) noexcept;
  ~Filter();

  [[nodiscard]] bool Accepts(const google::protobuf::Message& message) const;

  class Term;

 private:
  std::unique_ptr<Term> root_;
};

}  // namespace hgros::cli
