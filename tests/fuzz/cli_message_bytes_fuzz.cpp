// Messages come from other sessions, which may be hostile. Any bytes that are a message can be shown, and no text has
// characters that a terminal obeys.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include <foxglove/Log.pb.h>
#include <foxglove/SceneUpdate.pb.h>
#include <hgros/Snapshot.pb.h>

#include "messages/csv.hpp"
#include "messages/message_text.hpp"
#include "terminal/json.hpp"
#include "terminal/visible_text.hpp"

namespace {

void Require(bool condition) {
  if (!condition) std::abort();
}

template <class T>
void Show(std::string_view bytes) {
  T message;
  if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return;
  std::string yaml;
  hgros::cli::AppendYaml(yaml, {&message, nullptr, -1}, {});
  Require(hgros::cli::VisibleLines(yaml) == yaml);
  hgros::cli::Json json;
  hgros::cli::WriteJson(json, {&message, nullptr, -1});
  Require(hgros::cli::Visible(json.text()) == json.text());
  const std::string row = hgros::cli::Csv(*T::descriptor(), {}).Row(message);
  Require(hgros::cli::Visible(row) == row);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  Show<foxglove::Log>(bytes);
  Show<foxglove::SceneUpdate>(bytes);
  Show<hgros::Snapshot>(bytes);
  return 0;
}
