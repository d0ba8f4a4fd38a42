#include "session/control/steering.hpp"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <future>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/codec/message.hpp"
#include "hgros/codec/raw_message.hpp"

namespace hgros {
namespace {

// The answer leaves before the process gets the signal.
constexpr auto kTimeToAnswer = std::chrono::milliseconds(100);
// After this time callbacks in flight are taken for hanging, so that the next request has its turn.
constexpr auto kTimeForCallbacks = std::chrono::seconds(1);
// The last 64 replies are kept, so larger schemas would take too much memory.
constexpr std::size_t kMostSchemaBytes = std::size_t{256} * 1024;
constexpr std::string_view kOfTheLibrary = "hgros/";
constexpr std::array<const char*, 4> kLevels{"debug", "info", "warning", "error"};  // By LogLevel.

// Why SIGTERM does not end the process; null: it does, or the program handles it.
const char* WhyNotStopped() {
  struct sigaction action {};
  if (sigaction(SIGTERM, nullptr, &action) != 0) return nullptr;
  if (action.sa_handler == SIG_IGN) return "The process ignores SIGTERM, so it can only be killed.";
  if (action.sa_handler == SIG_DFL && getpid() == 1) {
    return "The process is number 1 of its container and does not handle SIGTERM, so it can only be killed. Run the "
           "container with --init.";
  }
  return nullptr;
}

// The channels that the session uses itself.
std::vector<std::string> NamesIn(const DataGraph& graph) {
  std::vector<std::string> names;
  for (const ChannelSnapshot& channel : graph.Snapshot().channels) {
    if (!channel.name.starts_with(kOfTheLibrary) && !channel.type.empty()) names.push_back(channel.name);
  }
  return names;
}

}  // namespace

Steering::Steering(NetworkBridge& bridge, Means means) : means_(std::move(means)), desk_(bridge, MeansOfDesk()) {}

ControlDesk::Means Steering::MeansOfDesk() {
  return {
      .self = means_.self,
      .log = means_.log,
      .name_of =
          [this](SessionId id) {
            const std::vector<PeerInfo> peers = means_.peers();
            const auto found = std::ranges::find(peers, id, &PeerInfo::id);
            return found == peers.end() ? id.ToString() : found->name();
          },
      .obey = [this](const ControlRequest& request, ControlReply& reply) { Obey(request, reply); },
      .open_replies =
          [this] {
            return means_.outbound.OpenForService(std::string(kControlRepliesChannel), TypeOf<ControlReply>(),
                                                  {[] {}, [] {}, [] { return true; }}, false);
          },
      .post = [this](std::function<void()> errand) { Post(std::move(errand)); },
  };
}

void Steering::Post(std::function<void()> errand) {
  const std::scoped_lock lock(starting_);
  if (!orders_) orders_.emplace(means_.log);
  orders_->Post(std::move(errand));
}

void Steering::End() {
  Close();  // From here on nothing is posted.
  if (orders_) orders_->End();
}

bool Steering::Forbids(const std::string& channel) const {
  const std::scoped_lock lock(mutex_);
  return forbidden_.contains(channel);
}

void Steering::AddTo(SessionSnapshot& snapshot, const std::optional<Steering>& steering, const Config& config,
                     bool has_domain, const std::vector<ChannelUse>& uses) {
  if (steering) {
    snapshot.steerable = true;
    snapshot.refused_orders = steering->desk_.refused();
  }
  const auto add = [&](auto& reasons, const ChannelUse& use, const std::vector<EndpointConfig>& endpoints, Way way) {
    std::string why;
    if (steering && steering->Forbids(use.channel)) {
      why = "Channel \"" + use.channel + "\" is forbidden in this session: it neither leaves nor enters it.";
      snapshot.forbidden.insert(use.channel);
    } else {
      why = DescribeConfined(use.channel, endpoints, way, OutermostPlace(config, has_domain));
    }
    if (!why.empty()) reasons[use.channel] = std::move(why);
  };
  for (const ChannelUse& use : uses) {
    if (use.channel.starts_with(kOfTheLibrary)) continue;
    if (use.publishes) add(snapshot.not_leaving, use, config.publishers, Way::kOut);
    if (use.subscribes) add(snapshot.not_entering, use, config.subscribers, Way::kIn);
  }
}

void Steering::Obey(const ControlRequest& request, ControlReply& reply) {
  switch (request.action()) {
    case ControlRequest::CLOSE:
    case ControlRequest::OPEN:
    case ControlRequest::ALLOW:
    case ControlRequest::FORBID: return reply.set_done(ChangeChannel(request));
    case ControlRequest::LOG: return reply.set_done(SetLogLevel(request.level()));
    case ControlRequest::STOP: return reply.set_done(Stop());
    case ControlRequest::DESCRIBE: return Describe(request.channel(), reply);
    default: throw Error("The session does not know action " + std::to_string(request.action()) + ".");
  }
}

void Steering::Describe(const std::string& name, ControlReply& reply) const {
  const std::string channel = "Channel \"" + name + "\" ";
  // Opened only if it exists, because a request must not create channels.
  const auto channels = means_.graph.Snapshot().channels;
  if (std::ranges::find(channels, name, &ChannelSnapshot::name) == channels.end()) {
    throw Error(channel + "is not used by this session.");
  }
  const TypeInfo& type = DataGraph::TypeOfChannel(means_.graph.Open(name, AnyType(), CallSite::Current()));
  if (IsAnyType(type)) throw Error(channel + "is used with any type by this session.");
  MessageSchema schema = SchemaOf(type);
  if (schema.encoding != Encoding::kProtobuf || schema.descriptor_set.empty()) {
    throw Error(channel + "has the type " + type.name + ", which has no protobuf schema.");
  }
  if (schema.descriptor_set.size() > kMostSchemaBytes) {
    throw Error(channel + "has the type " + type.name + ", whose schema of " +
                std::to_string(schema.descriptor_set.size()) + " bytes is larger than " +
                std::to_string(kMostSchemaBytes) + " bytes.");
  }
  reply.set_done(channel + "has the type " + type.name + ".");
  reply.set_type(std::move(schema.type_name));
  reply.set_fingerprint(schema.fingerprint);
  reply.set_descriptor_set(std::move(schema.descriptor_set));
}

std::string Steering::ChangeChannel(const ControlRequest& request) {
  const std::string& channel = request.channel();
  std::string done = "Channel \"" + channel + "\" ";
  RequireChannelName(channel);
  if (channel.starts_with(kOfTheLibrary)) throw Error(done + "belongs to the library: it cannot be changed.");
  if (request.action() == ControlRequest::CLOSE || request.action() == ControlRequest::OPEN) {
    const bool close = request.action() == ControlRequest::CLOSE;
    means_.graph.SetClosed(channel, close);
    done += close ? "is closed: what this session publishes there does not reach its own nodes."
                  : "is open: what this session publishes there reaches its own nodes.";
  } else {
    done += ForbidOrAllow(channel, request.action() == ControlRequest::FORBID);
  }
  const std::vector<std::string> used = NamesIn(means_.graph);
  if (std::ranges::find(used, channel) != used.end()) return done;
  const std::string nearest = NearestName(channel, used);
  return done + " So far this session does not use a channel of that name." +
         (nearest.empty() ? "" : " Did you mean \"" + nearest + "\"?");
}

std::string Steering::ForbidOrAllow(const std::string& channel, bool forbid) {
  const auto change =
      std::make_shared<std::packaged_task<bool()>>([this, channel, forbid] { return SetForbidden(channel, forbid); });
  std::future<bool> loses = change->get_future();
  means_.later({}, [change] { (*change)(); });
  if (loses.wait_for(kTimeForCallbacks) != std::future_status::ready) {
    return std::string(forbid ? "will be forbidden" : "will be allowed") +
           " when a callback of this session that runs now has returned.";
  }
  const std::string done = forbid ? "is forbidden: it neither leaves nor enters this session."
                                  : "is allowed to leave and to enter this session.";
  return done + (loses.get() ? " Messages on their way to its lossless subscriptions are lost." : "");
}

bool Steering::SetForbidden(const std::string& channel, bool forbid) {
  const auto mark = [&](bool forbidden) {
    const std::scoped_lock lock(mutex_);
    if (forbidden) forbidden_.insert(channel);
    if (!forbidden) forbidden_.erase(channel);
  };
  if (forbid) mark(true);
  bool loses = false;
  try {
    means_.outbound.SetForbidden(channel, forbid, means_.later);
    loses = means_.inbound.SetForbidden(channel, forbid);
  } catch (...) {  // A channel that could not be allowed remains marked, and may be allowed once more.
    if (!forbid) throw;
    means_.outbound.SetForbidden(channel, false, means_.later);
    (void)means_.inbound.SetForbidden(channel, false);
    mark(false);
    throw;
  }
  if (forbid) return loses;
  mark(false);
  for (const Way way : {Way::kOut, Way::kIn}) means_.list(way, channel);
  return false;
}

std::string Steering::SetLogLevel(std::uint32_t level) {
  if (level >= kLevels.size()) throw Error("There is no log level " + std::to_string(level) + ".");
  means_.log->SetLevel(static_cast<LogLevel>(level));
  return std::string("Log lines below the level ") + kLevels.at(level) + " are not written.";
}

std::string Steering::Stop() {
  if (const char* why = WhyNotStopped(); why != nullptr) throw Error(why);
  orders_->PostIn(kTimeToAnswer, [] { (void)kill(getpid(), SIGTERM); });
  return "Its process " + std::to_string(getpid()) + " gets SIGTERM.";
}

}  // namespace hgros
