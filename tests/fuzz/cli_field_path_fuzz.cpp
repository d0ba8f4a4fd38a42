// A path of `hgros echo --field` may be any text. It names a place, or is refused with UsageError. What is at the place
// in any message can be shown. The input is a path and the bytes of a message, separated by a line "=".
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>

#include <foxglove/FrameTransforms.pb.h>
#include <foxglove/LaserScan.pb.h>

#include "arguments/arguments.hpp"
#include "messages/csv.hpp"
#include "messages/field_path.hpp"
#include "messages/message_text.hpp"
#include "terminal/visible_text.hpp"

namespace {

void Require(bool condition) {
  if (!condition) std::abort();
}

void Show(const std::optional<hgros::cli::FieldRef>& place) {
  if (!place) return;
  std::string yaml;
  hgros::cli::AppendYaml(yaml, *place, {});
  Require(hgros::cli::VisibleLines(yaml) == yaml);
  Require(hgros::cli::ValidUtf8(hgros::cli::PlainText(*place)) == hgros::cli::PlainText(*place));
}

template <class T>
void Find(std::string_view path_text, std::string_view bytes) {
  try {
    const auto path = hgros::cli::FieldPath::Parse(path_text, *T::descriptor());
    const hgros::cli::Csv csv(*T::descriptor(), {std::string(path_text)});
    T message;
    Show(path.Find(message));
    if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return;
    Show(path.Find(message));
    const std::string row = csv.Row(message);
    Require(row.empty() || hgros::cli::VisibleLines(row) == row);
  } catch (const hgros::cli::UsageError& error) {
    Require(*error.what() != '\0');
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::size_t border = text.find("\n=\n");
  const std::string_view path = text.substr(0, border);
  const std::string_view bytes = border == std::string_view::npos ? std::string_view() : text.substr(border + 3);
  Find<foxglove::LaserScan>(path, bytes);
  Find<foxglove::FrameTransforms>(path, bytes);
  return 0;
}
