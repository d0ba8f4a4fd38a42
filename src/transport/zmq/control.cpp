#include "transport/zmq/control.hpp"

#include <cstddef>

namespace hgros::zmq {
namespace {

constexpr std::size_t kIdDigits = 16;
constexpr std::size_t kNumberBytes = 8;

}  // namespace

std::string ControlTopic(SessionId session) { return kControlByte + session.ToString(); }

std::optional<SessionId> ParseControlTopic(std::string_view topic) noexcept {
  if (topic.size() != 1 + kIdDigits || topic[0] != kControlByte) return std::nullopt;
  const auto session = SessionId::FromString(topic.substr(1));
  if (session.value == 0) return std::nullopt;
  return session;
}

std::optional<DataTopic> ParseDataTopic(Bytes frame) noexcept {
  const std::string_view text = AsText(frame);
  // Channel names have no control characters: the first one ends the name and identifies the form.
  const std::size_t end = text.find_first_of(std::string_view("\0\1", 2));
  if (end == 0 || end == std::string_view::npos) return std::nullopt;
  if (text[end] == '\0') {
    if (end + 1 != text.size()) return std::nullopt;
    return DataTopic{.channel = text.substr(0, end), .session = {}, .number = 0};
  }
  if (text.size() != end + 1 + kIdDigits + kNumberBytes) return std::nullopt;
  const auto session = SessionId::FromString(text.substr(end + 1, kIdDigits));
  if (session.value == 0) return std::nullopt;
  std::uint64_t number = 0;
  for (std::size_t i = kNumberBytes; i-- > 0;) {
    number = number << 8 | static_cast<unsigned char>(text[end + 1 + kIdDigits + i]);
  }
  return DataTopic{.channel = text.substr(0, end), .session = session, .number = number};
}

void WriteLinkNumber(std::string& topic, std::uint64_t number) noexcept {
  for (std::size_t i = 0; i < kNumberBytes; ++i) {
    topic[topic.size() - kNumberBytes + i] = static_cast<char>(number >> (8 * i) & 0xff);
  }
}

std::optional<wire::Control> ParseControl(Bytes bytes) {
  if (bytes.size() > kMaxControlBytes) return std::nullopt;
  wire::Control control;
  if (!control.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return std::nullopt;
  if (control.session() == 0 || control.what_case() == wire::Control::WHAT_NOT_SET) return std::nullopt;
  return control;
}

wire::Control ControlFrom(SessionId session) {
  wire::Control control;
  control.set_session(session.value);
  return control;
}

std::string UpstreamFrame(const wire::Control& control) {
  std::string frame(1, kControlByte);
  control.AppendToString(&frame);
  return frame;
}

}  // namespace hgros::zmq
