#include "transport/zmq/control.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <array>
#include <cstdio>

#include "hgros/codec/packet.hpp"
#include "hgros/codec/schema_compatibility.hpp"

namespace hgros::zmq {
namespace {

constexpr std::size_t kIdDigits = 16;
constexpr std::size_t kNumberBytes = 8;

std::string_view EncodingName(std::uint32_t encoding) {
  constexpr std::array<std::string_view, 4> kNames{"none", "protobuf", "custom", "plain"};
  return encoding < kNames.size() ? kNames[encoding] : "unknown encoding";
}

std::string DescribeType(const std::string& name, std::uint32_t encoding, std::uint64_t fingerprint) {
  char digits[24];
  std::snprintf(digits, sizeof digits, "0x%016llx", static_cast<unsigned long long>(fingerprint));
  return name + " (" + std::string(EncodingName(encoding)) + ", " + digits + ")";
}

}  // namespace

std::string Readable(const std::string& text) {
  std::string readable = text.substr(0, kMaxTextBytes);
  for (char& c : readable) {
    if (static_cast<unsigned char>(c) < 0x20 || c == '\x7f') c = '?';
  }
  return readable;
}

std::string ControlTopic(SessionId session) { return kControlByte + session.ToString(); }

std::optional<SessionId> ParseControlTopic(std::string_view topic) noexcept {
  if (topic.size() != 1 + kIdDigits || topic[0] != kControlByte) return std::nullopt;
  const auto session = SessionId::FromString(topic.substr(1));
  if (session.value == 0) return std::nullopt;
  return session;
}

std::optional<DataTopic> ParseDataTopic(Bytes frame) noexcept {
  const std::string_view text = AsText(frame);
  // Channel names have no control characters: the first one ends the name and tells the form.
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

void WriteFacts(const SessionFacts& facts, wire::SessionFacts& to) {
  to.set_incarnation(facts.incarnation);
  to.set_process(facts.info.process.substr(0, kMaxTextBytes));
  to.set_host(facts.info.host.substr(0, kMaxTextBytes));
  to.set_pid(facts.info.pid);
  to.set_wire_major(kWireMajor);
  to.set_wire_minor(kWireMinor);
}

SessionFacts ReadFacts(SessionId session, const wire::SessionFacts& from) {
  SessionFacts facts;
  facts.info.id = session;
  facts.info.process = Readable(from.process());
  facts.info.host = Readable(from.host());
  facts.info.pid = from.pid();
  facts.incarnation = from.incarnation();
  return facts;
}

void WriteType(std::string_view channel, const TypeInfo& type, wire::ChannelType& to) {
  to.set_channel(std::string(channel));
  to.set_type_name(type.name);
  to.set_encoding(static_cast<std::uint32_t>(type.encoding));
  to.set_fingerprint(type.fingerprint);
}

TypeFit CompareTypes(const wire::ChannelType& theirs, const TypeInfo& ours) noexcept {
  if (theirs.type_name() != ours.name || theirs.encoding() != static_cast<std::uint32_t>(ours.encoding)) {
    return TypeFit::kDiffer;
  }
  if (theirs.fingerprint() == 0 || ours.fingerprint == 0 || theirs.fingerprint() == ours.fingerprint) {
    return TypeFit::kEqual;
  }
  return ours.encoding == Encoding::kProtobuf ? TypeFit::kEvolved : TypeFit::kDiffer;
}

std::string DescribeMismatch(const wire::ChannelType& theirs, const TypeInfo& ours) {
  return "channel " + Readable(theirs.channel()) + ": here " +
         DescribeType(ours.name, static_cast<std::uint32_t>(ours.encoding), ours.fingerprint) + ", there " +
         DescribeType(Readable(theirs.type_name()), theirs.encoding(), theirs.fingerprint());
}

std::string SchemaFault(const std::string& their_descriptor_set, const TypeInfo& ours) {
  namespace pb = google::protobuf;
  if (const auto* known = pb::DescriptorPool::generated_pool()->FindMessageTypeByName(ours.name)) {
    const auto verdict = CheckSchemas(their_descriptor_set, ours.name, *known);
    return verdict.compatible ? std::string() : verdict.reason;
  }
  if (ours.descriptor_set == nullptr) return "this side has no schema of " + ours.name + " to compare with";
  pb::FileDescriptorSet files;
  pb::DescriptorPool pool;
  if (!files.ParseFromString(ours.descriptor_set())) return "this side's schema of " + ours.name + " does not parse";
  for (const auto& file : files.file()) {
    if (pool.BuildFile(file) == nullptr) return "this side's schema of " + ours.name + " cannot be built";
  }
  const auto* built = pool.FindMessageTypeByName(ours.name);
  if (built == nullptr) return "this side's schema does not contain " + ours.name;
  const auto verdict = CheckSchemas(their_descriptor_set, ours.name, *built);
  return verdict.compatible ? std::string() : verdict.reason;
}

}  // namespace hgros::zmq
