#include "transport/agreement.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <unistd.h>

#include <array>
#include <cstdio>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/base/readable_text.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/codec/run_time_type.hpp"
#include "hgros/codec/schema_compatibility.hpp"
#include "hgros/internal/codec/packet.hpp"

namespace hgros {
namespace {

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

SessionFacts OwnFacts(SessionId session, const std::string& process) {
  SessionFacts facts;
  facts.info.id = session;
  facts.info.process = process;
  char host[256] = {};
  if (gethostname(host, sizeof host - 1) == 0) facts.info.host = host;
  facts.info.pid = getpid();
  facts.incarnation = static_cast<std::uint64_t>(WallNow().nanoseconds);
  return facts;
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
  facts.info.process = Readable(from.process(), kMaxTextBytes);
  facts.info.host = Readable(from.host(), kMaxTextBytes);
  facts.info.pid = from.pid();
  facts.incarnation = from.incarnation();
  facts.wire_minor = from.wire_minor();
  return facts;
}

void WriteType(std::string_view channel, const TypeInfo& type, wire::ChannelType& to) {
  to.set_channel(std::string(channel));
  if (IsAnyType(type)) return;
  to.set_type_name(type.name);
  to.set_encoding(static_cast<std::uint32_t>(type.encoding));
  to.set_fingerprint(type.fingerprint);
}

std::optional<ChannelUse> ReadUse(const wire::ChannelType& from) {
  if (!ChannelNameFault(from.channel()).empty()) return std::nullopt;
  ChannelUse use{.channel = from.channel()};
  use.type_name = Readable(from.type_name(), kMaxTextBytes);
  const bool known = from.encoding() <= static_cast<std::uint32_t>(Encoding::kPlain);
  if (known) use.encoding = static_cast<Encoding>(from.encoding());
  use.fingerprint = from.fingerprint();
  return use;
}

TypeFit CompareTypes(const wire::ChannelType& theirs, const TypeInfo& ours) noexcept {
  if (IsAnyType(ours)) return TypeFit::kEqual;
  if (theirs.type_name() != ours.name || theirs.encoding() != static_cast<std::uint32_t>(ours.encoding)) {
    return TypeFit::kDiffer;
  }
  if (theirs.fingerprint() == 0 || ours.fingerprint == 0 || theirs.fingerprint() == ours.fingerprint) {
    return TypeFit::kEqual;
  }
  return ours.encoding == Encoding::kProtobuf ? TypeFit::kEvolved : TypeFit::kDiffer;
}

std::string DescribeMismatch(const wire::ChannelType& theirs, const PeerInfo& peer, const TypeInfo& ours,
                             const PeerInfo& self, bool peer_publishes) {
  std::string there = Readable(theirs.type_name(), kMaxTextBytes);
  std::string here = ours.name;
  if (there == here) {
    there = DescribeType(there, theirs.encoding(), theirs.fingerprint());
    here = DescribeType(here, static_cast<std::uint32_t>(ours.encoding), ours.fingerprint);
  }
  std::string text = Readable(theirs.channel(), kMaxTextBytes) + ": ";
  return peer_publishes ? text + peer.name() + " publishes " + there + ", " + self.name() + " subscribes to " + here
                        : text + self.name() + " publishes " + here + ", " + peer.name() + " subscribes to " + there;
}

std::string SchemaFault(const std::string& their_descriptor_set, const TypeInfo& ours) {
  namespace pb = google::protobuf;
  const auto* known = ours.run_time != nullptr ? DescriptorOf(ours)
                                               : pb::DescriptorPool::generated_pool()->FindMessageTypeByName(ours.name);
  if (known != nullptr) {
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

std::shared_ptr<const MessageSchema> ReadSchema(const wire::ChannelType& offered, const std::string& descriptor_set,
                                                const PeerInfo& from, Log& log) {
  constexpr std::size_t kMaxDescriptorSetBytes = 1 << 20;
  auto schema = std::make_shared<MessageSchema>();
  schema->type_name = Readable(offered.type_name(), kMaxTextBytes);
  const bool known = offered.encoding() <= static_cast<std::uint32_t>(Encoding::kPlain);
  if (known) schema->encoding = static_cast<Encoding>(offered.encoding());
  schema->fingerprint = offered.fingerprint();
  if (descriptor_set.size() <= kMaxDescriptorSetBytes) {
    schema->descriptor_set = descriptor_set;
  } else {
    const std::string channel = Readable(offered.channel(), kMaxTextBytes);
    log.WriteLimited(LogLevel::kWarning, "large schema " + channel,
                     "Channel " + channel + ": " + from.name() + " describes " + schema->type_name + " with " +
                         std::to_string(descriptor_set.size()) + " bytes. A description of more than " +
                         std::to_string(kMaxDescriptorSetBytes) + " bytes is refused.");
  }
  return schema;
}

std::optional<std::string> SchemaFor(const wire::ChannelType& wanted, const TypeInfo& type) {
  const bool takes_any = wanted.type_name().empty() && wanted.encoding() == 0;
  if (takes_any) return DescriptorSetOf(type);
  switch (CompareTypes(wanted, type)) {
    case TypeFit::kEqual: return std::string();
    case TypeFit::kEvolved: return DescriptorSetOf(type);
    case TypeFit::kDiffer: break;
  }
  return std::nullopt;
}

std::string ListedAs(const std::string& channel) {
  constexpr std::string_view kReplies = "hgros/reply/";
  constexpr std::size_t kIdDigits = 16;
  const std::size_t name = kReplies.size() + kIdDigits + 1;
  if (!channel.starts_with(kReplies) || channel.size() <= name || channel[name - 1] != '/') return channel;
  return "hgros/call/" + channel.substr(name);
}

void LogTooManyChannels(Log& log, const PeerInfo& peer, const std::string& channel, std::string_view transport) {
  log.WriteLimited(LogLevel::kError, "too many channels of " + peer.id.ToString(),
                   "This session subscribes to more than " + std::to_string(kMaxChannels) + " channels: \"" + channel +
                       "\" is not received from session " + peer.name() + " through " + std::string(transport) +
                       ". Subscribe to fewer channels, or split the program into two sessions.");
}

void RequireTypeName(const TypeInfo& type) {
  if (!IsReadable(type.name)) {
    throw Error("The type's name cannot be used: it has control characters, or is not UTF-8: " +
                    Readable(type.name, kMaxTextBytes) + ".",
                {}, "Use visible UTF-8 text.");
  }
  if (type.name.size() <= kMaxTypeNameBytes) return;
  throw Error("The type's name has " + std::to_string(type.name.size()) + " bytes, more than " +
                  std::to_string(kMaxTypeNameBytes) + ": " + type.name.substr(0, 100) + "...",
              {}, "Give it a shorter one.");
}

}  // namespace hgros
