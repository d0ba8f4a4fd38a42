// `hgros echo --filter` takes any text. It is a condition, or refused with UsageError, in bounded time. A condition
// judges any message. The input is a filter and the bytes of a message, separated by a line "=".
#include <cstdint>
#include <string_view>

#include <foxglove/FrameTransforms.pb.h>
#include <foxglove/LaserScan.pb.h>
#include <foxglove/Log.pb.h>

#include "arguments/arguments.hpp"
#include "messages/filter.hpp"

namespace {

template <class T>
void Judge(std::string_view filter_text, std::string_view bytes) {
  try {
    const hgros::cli::Filter filter(filter_text, *T::descriptor());
    T message;
    (void)filter.Accepts(message);
    if (message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) (void)filter.Accepts(message);
  } catch (const hgros::cli::UsageError& error) {
    if (*error.what() == '\0') __builtin_trap();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::size_t border = text.find("\n=\n");
  const std::string_view filter = text.substr(0, border);
  const std::string_view bytes = border == std::string_view::npos ? std::string_view() : text.substr(border + 3);
  Judge<foxglove::LaserScan>(filter, bytes);
  Judge<foxglove::Log>(filter, bytes);
  Judge<foxglove::FrameTransforms>(filter, bytes);
  return 0;
}
