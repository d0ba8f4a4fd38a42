#include <fmt/format.h>
#include <google/protobuf/message.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "hgros/base/names.hpp"
#include "messages/message_reader.hpp"
#include "messages/message_text.hpp"
#include "messages/type_finder.hpp"
#include "robot/channel_type.hpp"
#include "robot/overview.hpp"
#include "robot/robot.hpp"
#include "terminal/json.hpp"
#include "terminal/pause.hpp"
#include "terminal/progress.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::chrono::seconds kReplyTime{10};

// Written by a thread of the session, which may come after the command has been interrupted.
struct Ending {
  std::mutex mutex;
  std::optional<CallResult<RawMessage>> result;

  [[nodiscard]] std::optional<CallResult<RawMessage>> Get() {
    const std::scoped_lock lock(mutex);
    return result;
  }
};

class Call final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"SERVICE", "", "The service", ValueKind::kService, {}, true}, service_);
    arguments.Positional({"YAML", "", "The request, such as '{x: 1}'; without it all fields are unset"}, request_);
    arguments.Option("--type", "TYPE", type_, "Type of the request; without it the type that the server has",
                     ValueKind::kType);
    arguments.Option("--reply-type", "TYPE", reply_type_,
                     "Type of the reply; without it the type that the server sends", ValueKind::kType);
    types_.Declare(arguments);
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Calls a service and shows its reply as YAML. Ends with code 3 if no reply comes within 10 seconds, or "
           "within "
           "--timeout.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros call ask '{message: hello}'", "Calls the service ask."},
            {"hgros call ask '{message: hello}' --json --timeout 1", "Waits at most a second; the reply is JSON."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  void RequireServer(Robot& robot) const;
  void Show(Console& console, const TypeFinder& finder, const RawMessage& reply, std::chrono::nanoseconds took) const;

  std::string service_;
  std::string request_;
  std::string type_;
  std::string reply_type_;
  TypeOptions types_;
  RobotOptions options_;
};

void Call::RequireServer(Robot& robot) const {
  const auto is_served = [&] { return !ChannelNamed(robot, "hgros/call/" + service_).subscribers.empty(); };
  if (AwaitChannels(robot, options_, "a server of " + service_, is_served)) return;
  std::vector<std::string> served;
  for (const KnownChannel& channel : robot.Channels(true)) {
    const std::string_view name = ServiceOf(channel.name);
    if (!name.empty() && !channel.subscribers.empty()) served.emplace_back(name);
  }
  const std::string nearest = NearestName(service_, served);
  options_.GiveUp(
      "No session serves " + service_ + "." +
      (nearest.empty() ? " `hgros list services` shows what is served." : " Did you mean " + nearest + "?"));
}

void Call::Show(Console& console, const TypeFinder& finder, const RawMessage& reply,
                std::chrono::nanoseconds took) const {
  MessageSchema schema = *reply.schema;
  if (schema.descriptor_set.empty() && schema.encoding == Encoding::kProtobuf) {
    schema = SchemaFor(finder.Require(schema.type_name));
  }
  const ChannelType type = TypeFrom(std::move(schema));
  std::string fault;
  const auto message = type.type->Read(reply.data.bytes, fault);
  if (message == nullptr) throw Error("The reply cannot be read as " + type.schema.type_name + ". " + fault);
  if (!options_.style.json) {
    std::string text;
    AppendYaml(text, {message.get(), nullptr, -1}, TextLimits::None());
    return console.Write(text);
  }
  Json json;
  json.BeginObject().Member("service", service_).Member("type", type.schema.type_name);
  json.Member("duration_ns", std::int64_t{took.count()});
  WriteJson(json.Key("message"), {message.get(), nullptr, -1});
  json.EndObject();
  console.Line(json.text());
}

int Call::Run(Surroundings& surroundings) {
  const MessageDocument document = MessageDocument::Parse(request_, "request");
  const TypeFinder finder(types_);
  const MessageSchema reply_schema = reply_type_.empty() ? MessageSchema{} : SchemaFor(finder.Require(reply_type_));
  Robot robot(options_, surroundings);
  RequireServer(robot);
  const ChannelType type = TypeOfChannel(robot, options_, finder, "hgros/call/" + service_, type_);
  const std::unique_ptr<google::protobuf::Message> request = type.type->Read({});
  ReadMessage(document, *request);
  const std::string bytes = request->SerializePartialAsString();

  const auto ending = std::make_shared<Ending>();
  const auto begin = std::chrono::steady_clock::now();
  const CallTicket ticket = robot.session().CallRaw(
      service_, type.schema, {AsBytes(bytes), nullptr}, reply_schema, options_.Timeout(kReplyTime),
      [ending, &pause = surroundings.pause](const CallResult<RawMessage>& end) {
        {
          const std::scoped_lock lock(ending->mutex);
          ending->result = end;
        }
        pause.Wake();
      });
  const Progress progress(surroundings.console, surroundings.pause, "waiting for the reply of " + Visible(service_),
                          options_.Timeout(kReplyTime));
  std::optional<CallResult<RawMessage>> result;
  while (!(result = ending->Get())) {
    if (surroundings.pause.For(std::chrono::hours(1)) != Pause::End::kInterrupted) continue;
    ticket.Cancel();
    return kDone;
  }
  const auto took = std::chrono::steady_clock::now() - begin;
  if (*result) {
    Show(surroundings.console, finder, **result, took);
    return kDone;
  }
  const CallFailure& failure = result->failure();
  const bool unheard = failure.kind == CallFailure::Kind::kNoServer || failure.kind == CallFailure::Kind::kTimedOut;
  surroundings.console.Say(Visible(failure.reason) + (unheard ? options_.SendingHint() : ""));
  const bool late =
      failure.kind == CallFailure::Kind::kNoServer && options_.Timeout(std::chrono::hours(1)).count() == 0;
  return late || failure.kind == CallFailure::Kind::kTimedOut ? kTimedOut : kFailed;
}

}  // namespace

std::unique_ptr<Command> MakeCall() { return std::make_unique<Call>(); }

}  // namespace hgros::cli
