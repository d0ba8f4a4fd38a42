#include "robot/channel_type.hpp"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <utility>

#include "hgros/base/names.hpp"
#include "hgros/codec/schema.hpp"
#include "robot/overview.hpp"
#include "terminal/pause.hpp"

namespace hgros::cli {
namespace {

// The schema that the channel's publishers send. Null if it does not come. Never asked of a channel with the calls of a
// service, because a subscriber of that is a server.
std::shared_ptr<const MessageSchema> PublishedSchema(Robot& robot, const RobotOptions& options,
                                                     const KnownChannel& channel) {
  if (channel.publishers.empty() || !ServiceOf(channel.name).empty()) return nullptr;
  // Keeps the connection between the slices.
  const Subscription connected = robot.session().FromAnyRaw(channel.name, Invoke::kConcurrent, [](const RawMessage&) {},
                                                            {.queue = Queue::Latest()});
  const auto deadline = std::chrono::steady_clock::now() + options.Timeout(std::chrono::seconds(1));
  constexpr auto kSlice = std::chrono::milliseconds(50);  // Ctrl-C must not wait longer.
  while (robot.surroundings().pause.For({}) != Pause::End::kInterrupted) {
    const auto left = deadline - std::chrono::steady_clock::now();
    if (left <= left.zero()) break;
    auto schema = robot.session().AwaitSchema(channel.name, std::min<std::chrono::nanoseconds>(left, kSlice));
    if (schema != nullptr && !schema->descriptor_set.empty()) return schema;
  }
  return nullptr;
}

}  // namespace

ChannelType TypeFrom(MessageSchema schema) {
  std::string fault;
  ChannelType type{std::move(schema), nullptr};
  type.type = DynamicSchema::Build(type.schema, fault);
  if (type.type == nullptr) throw Error("Messages of " + type.schema.type_name + " cannot be written: " + fault);
  return type;
}

bool AwaitChannels(Robot& robot, const RobotOptions& options, const std::function<bool()>& ready) {
  if (ready()) return true;
  Pause& pause = robot.surroundings().pause;
  const Subscription changes = robot.session().FromGraph<ChannelsChanged>(
      kChannelEventsChannel, Invoke::kSerial, [&pause](const ChannelsChanged&) { pause.Wake(); });
  const auto deadline = std::chrono::steady_clock::now() + options.Timeout(std::chrono::milliseconds(500));
  while (!ready()) {
    if (pause.Until(deadline) != Pause::End::kWoken) return ready();
  }
  return true;
}

KnownChannel ChannelNamed(const Robot& robot, const std::string& name) {
  return ChannelNamed(robot.Channels(true), name);
}

std::string ChannelOfType(const Robot& robot, const std::string& type) {
  for (const KnownChannel& channel : robot.Channels(true)) {
    const bool describes = !channel.publishers.empty() && ServiceOf(channel.name).empty();
    if (describes && channel.type_name == type && channel.encoding == Encoding::kProtobuf) return channel.name;
  }
  return {};
}

std::string NearestChannel(const Robot& robot, const std::string& name) {
  std::vector<std::string> names;
  for (const KnownChannel& channel : robot.Channels(false)) names.push_back(channel.name);
  return NearestName(name, names);
}

ChannelType TypeOfChannel(Robot& robot, const RobotOptions& options, const TypeFinder& finder,
                          const std::string& channel, const std::string& given) {
  KnownChannel known;
  const auto has_type = [&] {
    known = ChannelNamed(robot, channel);
    return !known.type_name.empty();
  };
  if (!has_type() && given.empty()) (void)AwaitChannels(robot, options, has_type);
  const std::string_view service = ServiceOf(channel);
  const std::string shown = service.empty() ? channel : "The service " + std::string(service);
  if (known.type_name.empty()) {
    if (!given.empty()) return TypeFrom(SchemaFor(finder.Require(given)));
    const std::string nearest = NearestChannel(robot, channel);
    throw Error("The type of " + shown + " is not known, because " +
                (known.subscribers.empty() ? "no session uses it. " : "its subscribers take any type. ") +
                (nearest.empty() ? "Name it with --type, such as --type foxglove.Log."
                                 : "Did you mean " + nearest + "? Otherwise name the type with --type."));
  }
  if (known.encoding != Encoding::kProtobuf) {
    throw Error(shown + " has the type " + known.type_name + ", which is not protobuf, so it has no known fields.");
  }
  if (!given.empty()) {
    const google::protobuf::Descriptor& wanted = finder.Require(given);
    if (wanted.full_name() != known.type_name) {
      throw Error(shown + " has the type " + known.type_name + ", not " + wanted.full_name() + ". Leave out --type.");
    }
  }
  const google::protobuf::Descriptor* local = finder.Find(known.type_name);
  if (local != nullptr && SchemaFingerprint(*local) == known.fingerprint) return TypeFrom(SchemaFor(*local));
  if (const auto schema = PublishedSchema(robot, options, known)) return TypeFrom(*schema);
  if (local != nullptr) return TypeFrom(SchemaFor(*local));
  throw Error("The type " + known.type_name + " of " + channel +
              " is not known here. Give its file with --proto, or the folder of its file with -I.");
}

}  // namespace hgros::cli
