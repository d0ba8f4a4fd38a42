#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "hgros/base/export.hpp"

namespace hgros {

/// A place in a text file. Lines and columns count from 1; 0 means unknown.
struct HGROS_EXPORT FilePosition {
  std::string file;
  int line = 0;
  int column = 0;

  /// "file:line:column" without the unknown parts.
  [[nodiscard]] std::string ToString() const;
  /// The same position from such a text.
  [[nodiscard]] static FilePosition From(std::string_view text);
};

/// Thrown while a program is set up: configuration, types, names, endpoints. The data path never throws.
///
/// what() has three parts: what is wrong, where, and how to fix it.
class HGROS_EXPORT Error : public std::runtime_error {
 public:
  /// `where` and `mend` may be empty. Sentences, without a final line break.
  explicit Error(std::string_view what, std::string_view where = {}, std::string_view mend = {});

  /// what() without the other two.
  [[nodiscard]] std::string sentence() const;
  [[nodiscard]] const std::string& where() const noexcept { return where_; }
  [[nodiscard]] const std::string& mend() const noexcept { return mend_; }

 private:
  std::string where_;
  std::string mend_;
};

/// A channel was opened with a type other than the one it carries.
class HGROS_EXPORT TypeMismatch : public Error {
 public:
  using Error::Error;
};

/// A configuration file or value cannot be used. where() is "file:line:column".
class HGROS_EXPORT ConfigError : public Error {
 public:
  ConfigError(std::string_view what, const FilePosition& position, std::string_view mend = {});
};

}  // namespace hgros
