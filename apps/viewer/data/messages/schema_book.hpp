#pragma once

#include <map>
#include <memory>
#include <string>

#include "hgros/codec/dynamic_schema.hpp"

namespace hgros::viewer {

/// Message types, built once from the schemas that publishers send. Thread safety: none.
class SchemaBook {
 public:
  /// Null if messages of that schema cannot be read; then fault() is a sentence that says why.
  [[nodiscard]] std::shared_ptr<const DynamicSchema> Find(const std::shared_ptr<const MessageSchema>& schema);
  [[nodiscard]] const std::string& fault() const noexcept { return fault_; }

 private:
  struct Entry {
    std::shared_ptr<const MessageSchema> schema;
    std::shared_ptr<const DynamicSchema> type;
    std::string fault;
  };
  static constexpr std::size_t kMost = 32;

  std::map<const MessageSchema*, Entry> entries_;
  std::string fault_;
};

}  // namespace hgros::viewer
