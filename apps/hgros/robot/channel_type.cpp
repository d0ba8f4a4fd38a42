#include "robot/channel_type.hpp"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <utility>

#include "hgros/base/names.hpp"
#include "hgros/codec/schema.hpp"
#include "hgros/session/session_control.hpp"
#include "robot/overview.hpp"
#include "terminal/pause.hpp"
#include "terminal/progress.hpp"
#include "terminal/visible_text.hpp"

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
  auto deadline = std::chrono::steady_clock::now() + options.Timeout(std::chrono::seconds(1));
  constexpr auto kSlice = std::chrono::milliseconds(50);  // Ctrl-C must not wait longer.
  constexpr auto kForOthers = 10 * kSlice;
  bool undescribed = false;
  while (robot.surroundings().pause.For({}) != Pause::End::kInterrupted) {
    const auto left = deadline - std::chrono::steady_clock::now();
    if (left <= left.zero()) break;
    auto schema = robot.session().AwaitSchema(channel.name, std::min<std::chrono::nanoseconds>(left, kSlice));
    if (schema == nullptr) continue;
    if (!schema->descriptor_set.empty()) return schema;
    // This publisher sends no other schema, but other publishers may. Each try makes it send the schema again.
    if (!std::exchange(undescribed, true)) deadline = std::min(deadline, std::chrono::steady_clock::now() + kForOthers);
    if (channel.publishers.size() == 1) break;
    if (!robot.surroundings().pause.SleepUntil(std::chrono::steady_clock::now() + kSlice)) break;
  }
  return nullptr;
}

constexpr std::uint32_t kDescribes = 2;  // The first version of hgros/control that describes types.

// The sessions that use the channel with its type and describe it if they are asked.
std::vector<SessionId> Describing(Robot& robot, const KnownChannel& channel) {
  const auto counters = robot.Counters();
  std::vector<SessionId> sessions;
  for (const auto* users : {&channel.subscribers, &channel.publishers}) {
    for (const ChannelUser& user : *users) {
      const auto found = counters.find(user.session);
      if (found == counters.end() || found->second->control() < kDescribes) continue;
      const bool typed = user.type_name == channel.type_name;
      if (typed && std::ranges::find(sessions, user.session) == sessions.end()) sessions.push_back(user.session);
    }
  }
  return sessions;
}

// The schema that a session tells that uses the channel, such as its subscriber. One after the other is asked, because
// one answer is enough. Null if none tells it.
std::shared_ptr<const MessageSchema> DescribedSchema(Robot& robot, const RobotOptions& options,
                                                     const KnownChannel& channel) {
  const std::vector<SessionId> sessions = Describing(robot, channel);
  const auto deadline = std::chrono::steady_clock::now() + options.Timeout(std::chrono::seconds(1));
  for (const SessionId& session : sessions) {
    const auto left = deadline - std::chrono::steady_clock::now();
    if (left <= left.zero() || robot.surroundings().pause.For({}) == Pause::End::kInterrupted) return nullptr;
    for (ControlAnswer& answer :
         AskSessions(robot.session(), {&session, 1}, {ControlAction::kDescribe, channel.name, {}}, left)) {
      const MessageSchema& schema = answer.schema;
      if (schema.type_name == channel.type_name && !schema.descriptor_set.empty()) {
        return std::make_shared<const MessageSchema>(std::move(answer.schema));
      }
    }
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

bool AwaitChannels(Robot& robot, const RobotOptions& options, const std::string& what,
                   const std::function<bool()>& ready, bool endless) {
  if (ready()) return true;
  Pause& pause = robot.surroundings().pause;
  const Subscription changes = robot.session().FromGraph<ChannelsChanged>(
      kChannelEventsChannel, Invoke::kSerial, [&pause](const ChannelsChanged&) { pause.Wake(); });
  const bool limited = !endless || options.timeout_s;
  const auto time = limited ? options.Timeout(std::chrono::milliseconds(500)) : std::chrono::nanoseconds(0);
  const auto deadline =
      limited ? std::chrono::steady_clock::now() + time : std::chrono::steady_clock::time_point::max();
  const Progress progress(robot.surroundings().console, pause, "waiting for " + Visible(what), time);
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
    if (channel.type_name == type && channel.encoding == Encoding::kProtobuf) return channel.name;
  }
  return {};
}

std::string NearestChannel(const Robot& robot, const std::string& name) {
  std::vector<std::string> names;
  for (const KnownChannel& channel : robot.Channels(false)) names.push_back(channel.name);
  return NearestName(name, names);
}

namespace {

// The channel as those use it who use it with this type; false: nobody does.
bool NarrowTo(KnownChannel& channel, std::string_view type) {
  KnownChannel narrowed = channel;
  narrowed.type_name.clear();
  for (auto* users : {&narrowed.subscribers, &narrowed.publishers}) {
    std::erase_if(*users, [&](const ChannelUser& user) { return user.type_name != type; });
    if (users->empty()) continue;
    narrowed.type_name = type;
    narrowed.encoding = users->front().encoding;
    narrowed.fingerprint = users->front().fingerprint;
  }
  if (narrowed.type_name.empty()) return false;
  channel = std::move(narrowed);
  return true;
}

}  // namespace

ChannelType TypeOfChannel(Robot& robot, const RobotOptions& options, const TypeFinder& finder,
                          const std::string& channel, const std::string& given, const std::string& otherwise) {
  KnownChannel known;
  const auto has_type = [&] {
    known = ChannelNamed(robot, channel);
    return !known.type_name.empty();
  };
  if (!has_type() && given.empty()) (void)AwaitChannels(robot, options, channel, has_type);
  const std::string_view service = ServiceOf(channel);
  const std::string shown = service.empty() ? channel : "The service " + std::string(service);
  if (known.type_name.empty()) {
    if (!given.empty()) return TypeFrom(SchemaFor(finder.Require(given)));
    if (!otherwise.empty()) return TypeFrom(SchemaFor(finder.Require(otherwise)));
    const std::string nearest = known.subscribers.empty() ? NearestChannel(robot, channel) : std::string();
    options.GiveUp("The type of " + shown + " is not known, because " +
                   (known.subscribers.empty() ? "no session uses it. " : "its subscribers take any type. ") +
                   (nearest.empty() ? "Name it with --type, such as --type foxglove.Log."
                                    : "Did you mean " + nearest + "? Otherwise name the type with --type."));
  }
  // The ends of a channel may differ in their types.
  const bool narrowed = !given.empty() && NarrowTo(known, finder.Require(given).full_name());
  if (known.encoding != Encoding::kProtobuf) {
    throw Error(shown + " has the type " + known.type_name + ", which is not protobuf, so it has no known fields.");
  }
  if (!given.empty() && !narrowed) {
    throw Error(shown + " has the type " + known.type_name + ", not " + finder.Require(given).full_name() +
                ". Leave out --type.");
  }
  const google::protobuf::Descriptor* local = finder.Find(known.type_name);
  if (local != nullptr && SchemaFingerprint(*local) == known.fingerprint) return TypeFrom(SchemaFor(*local));
  const auto published = PublishedSchema(robot, options, known);
  if (published && published->type_name == known.type_name) return TypeFrom(*published);
  if (const auto schema = DescribedSchema(robot, options, known)) return TypeFrom(*schema);
  if (local != nullptr) return TypeFrom(SchemaFor(*local));
  throw Error(
      "The type " + known.type_name + " of " + channel +
      " is not known here, and no session that uses it describes it: `control: off` is set there, it runs an older "
      "version, its description was refused, or it cannot be asked from here. Give the type's file with --proto, or "
      "the folder of its file with -I.");
}

}  // namespace hgros::cli
