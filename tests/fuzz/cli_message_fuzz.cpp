// `hgros pub` takes a message as any text: YAML or JSON. It is read, or refused with ConfigError, in bounded time. What
// was read is the same after it was written as JSON and as YAML and read again.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include <foxglove/Log.pb.h>
#include <foxglove/PointCloud.pb.h>
#include <foxglove/SceneUpdate.pb.h>

#include "hgros/base/error.hpp"
#include "messages/message_reader.hpp"
#include "messages/message_text.hpp"
#include "terminal/json.hpp"

namespace {

using hgros::cli::MessageDocument;

void Require(bool condition) {
  if (!condition) std::abort();
}

template <class T>
T Again(const std::string& text) {
  T message;
  const MessageDocument document = MessageDocument::Parse(text, "written");
  hgros::cli::ReadMessage(document, message);
  return message;
}

template <class T>
std::string JsonOf(const T& message) {
  hgros::cli::Json json;
  hgros::cli::WriteJson(json, {&message, nullptr, -1});
  return std::string(json.text());
}

template <class T>
void Read(std::string_view text) {
  T message;
  try {
    const MessageDocument document = MessageDocument::Parse(text, "fuzz");
    hgros::cli::ReadMessage(document, message);
  } catch (const hgros::ConfigError& error) {
    Require(error.where().starts_with("fuzz"));
    return;
  }
  const std::string json = JsonOf(message);
  Require(JsonOf(Again<T>(json)) == json);
  std::string yaml;
  hgros::cli::AppendYaml(yaml, {&message, nullptr, -1}, hgros::cli::TextLimits::None());
  if (yaml.size() < 100'000) Require(JsonOf(Again<T>(yaml)) == json);  // Larger ones may exceed the limits of YAML.
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  Read<foxglove::Log>(text);
  Read<foxglove::PointCloud>(text);
  Read<foxglove::SceneUpdate>(text);
  return 0;
}
