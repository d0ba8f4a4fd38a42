// A publisher's description of its messages, and a message of it, both arbitrary.
#include <google/protobuf/message.h>

#include <algorithm>
#include <cstdint>

#include "hgros/codec/dynamic_schema.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::size_t border = size > 0 ? std::min<std::size_t>(size, 1 + data[0] * size / 255) : 0;
  const hgros::MessageSchema schema{"p.M", hgros::Encoding::kProtobuf, 1,
                                    std::string(text.substr(border > 0 ? 1 : 0, border > 0 ? border - 1 : 0))};
  std::string fault;
  if (const auto type = hgros::DynamicSchema::Build(schema, fault)) {
    if (const auto message = type->Read(hgros::AsBytes(text.substr(border)))) (void)message->ByteSizeLong();
  } else if (fault.empty()) {
    __builtin_trap();
  }
  return 0;
}
