#pragma once

#include <cstddef>
#include <unordered_map>

#include "hgros/base/bytes.hpp"

namespace google::protobuf {
class Descriptor;
class MessageFactory;
}  // namespace google::protobuf

namespace hgros {

// Estimates the memory that a parsed protobuf message takes, without parsing it. Two bytes can make an object of a
// hundred, so a small message may take all the memory there is.
//
// Thread safety: all functions.
class ParsedMemory {
 public:
  // `type` and `factory` live longer.
  ParsedMemory(const google::protobuf::Descriptor& type, google::protobuf::MessageFactory& factory);

  // Whether `bytes` take at most `most` bytes of memory beyond their own number. The estimate is rather too high. Bytes
  // behind the first fault are not counted, because a parser stops there.
  [[nodiscard]] bool Fits(Bytes bytes, std::size_t most) const;

 private:
  class Walk;
  void AddSize(const google::protobuf::Descriptor& type, google::protobuf::MessageFactory& factory);

  const google::protobuf::Descriptor& type_;
  std::unordered_map<const google::protobuf::Descriptor*, std::size_t> sizes_;  // Of one message object of each type.
};

}  // namespace hgros
