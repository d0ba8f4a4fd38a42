#pragma once

#include <memory>
#include <string>
#include <vector>

#include "arguments/arguments.hpp"
#include "hgros/codec/raw_message.hpp"

namespace google::protobuf {
class Descriptor;
}

namespace hgros::cli {

/// Where a command finds types that no channel describes.
struct TypeOptions {
  std::vector<std::string> files;
  std::vector<std::string> folders;

  void Declare(Arguments& arguments);
};

/// Protobuf types by name: those of the files of --proto and of what they import, those in files a/b/C.proto below the
/// folders of -I and below the installed share/hgros/proto that are named as the type (a.b.C), and those that come with
/// the library.
///
/// Threading: one thread.
class TypeFinder {
 public:
  /// Reads the files. Throws ConfigError with file, line and column of what is wrong in them.
  explicit TypeFinder(const TypeOptions& options);
  TypeFinder(const TypeFinder&) = delete;
  TypeFinder& operator=(const TypeFinder&) = delete;
  ~TypeFinder();

  /// Null if there is none. "a/C" is a.C. Valid as long as this object. Throws ConfigError as above.
  [[nodiscard]] const google::protobuf::Descriptor* Find(const std::string& name) const;
  /// The same; throws UsageError with the nearest name if there is none.
  [[nodiscard]] const google::protobuf::Descriptor& Require(const std::string& name) const;
  /// The nearest known name, or empty.
  [[nodiscard]] std::string Nearest(const std::string& name) const;

 private:
  struct Parts;
  const std::unique_ptr<Parts> parts_;
};

/// The type as a publisher describes it.
[[nodiscard]] MessageSchema SchemaFor(const google::protobuf::Descriptor& type);

}  // namespace hgros::cli
