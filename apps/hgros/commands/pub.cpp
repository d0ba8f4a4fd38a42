#include <fmt/format.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "commands/commands.hpp"
#include "messages/message_document.hpp"
#include "messages/message_reader.hpp"
#include "messages/type_finder.hpp"
#include "robot/channel_type.hpp"
#include "robot/overview.hpp"
#include "robot/robot.hpp"
#include "terminal/json.hpp"
#include "terminal/line_reader.hpp"
#include "terminal/pause.hpp"
#include "terminal/progress.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

using SteadyTime = std::chrono::steady_clock::time_point;

constexpr std::chrono::hours kLongest{24 * 365};

struct PubOptions {
  std::string channel;
  std::string message;
  std::string type;
  std::optional<double> rate;
  std::optional<std::uint64_t> count;
  std::string file;
  bool as_recorded = false;
  bool latched = false;
  TypeOptions types;
  RobotOptions robot;

  [[nodiscard]] bool once() const noexcept { return file.empty() && !rate && !count; }
};

std::string_view MeaningOf(PublishStatus status) {
  switch (status) {
    case PublishStatus::kFull:
    case PublishStatus::kTimedOut: return "a lossless subscriber has no room for it";
    case PublishStatus::kTooLarge: return "it is larger than 1 GiB, the most that passes between sessions";
    case PublishStatus::kNoMemory: return "there is no memory for it";
    default: return ToString(status);
  }
}

// Publishes on one channel: first waits for the subscribers, then counts.
class Publishing {
 public:
  Publishing(const PubOptions& options, Robot& robot, const ChannelType& type)
      : options_(options),
        robot_(robot),
        type_(type),
        publish_(robot.session().AdvertiseRaw(options.channel, type.schema, {.latched = options.latched ? 1U : 0U})) {}

  // False if the user ended the command.
  [[nodiscard]] bool AwaitSubscribers();
  // Publishes one message. Throws Error if it was refused.
  void Publish(const MessageDocument& document, const yaml::Node& value);
  // False if the user ended the command. Throws TimedOut.
  [[nodiscard]] bool SleepUntil(SteadyTime time) const;
  // When --timeout is over.
  [[nodiscard]] SteadyTime end() const noexcept { return end_; }
  [[nodiscard]] const std::string& type_name() const noexcept { return type_.schema.type_name; }
  [[nodiscard]] std::uint64_t published() const noexcept { return published_; }
  [[nodiscard]] bool enough() const noexcept { return options_.count && published_ >= *options_.count; }
  // The most that had joined when they were counted: before the first message, and then every 100 ms. Without those
  // that take another type.
  [[nodiscard]] std::size_t subscribers() const noexcept { return subscribers_; }
  // Who takes another type, in one sentence; empty: nobody does.
  [[nodiscard]] const std::string& refusal() const noexcept { return refusal_; }
  // What was published, in one sentence.
  [[nodiscard]] std::string Sentence() const;
  void Report() const;

 private:
  // The subscribers that are known and take the type. Notes another one in refusal_.
  [[nodiscard]] std::size_t Fitting();
  void CountSubscribers();

  const PubOptions& options_;
  Robot& robot_;
  const ChannelType& type_;
  const RawPublisher publish_;
  const SteadyTime end_ = std::chrono::steady_clock::now() + options_.robot.Timeout(kLongest);
  std::uint64_t published_ = 0;
  std::uint64_t bytes_ = 0;
  std::size_t subscribers_ = 0;
  std::string refusal_;
  SteadyTime counted_;
};

bool Publishing::SleepUntil(SteadyTime time) const {
  if (!robot_.surroundings().pause.SleepUntil(std::min(time, end_))) return false;
  if (std::chrono::steady_clock::now() >= end_) throw TimedOut("Publishing takes longer than --timeout allows.");
  return true;
}

std::size_t Publishing::Fitting() {
  std::size_t fitting = 0;
  for (const ChannelUser& user : ChannelNamed(robot_, options_.channel).subscribers) {
    if (user.type_name.empty() || user.type_name == type_name()) {
      ++fitting;
    } else if (refusal_.empty()) {
      refusal_ = fmt::format("{} subscribes to {} with the type {}, not {}.", ShortName(user, false),
                             Visible(options_.channel), user.type_name, type_name());
    }
  }
  return fitting;
}

// Takes longer than publishing a small message.
void Publishing::CountSubscribers() {
  const auto now = std::chrono::steady_clock::now();
  if (now < counted_ + std::chrono::milliseconds(100)) return;
  counted_ = now;
  constexpr std::size_t kMost = 10'000;
  std::size_t count = 0;
  while (count < kMost && robot_.session().WaitForSubscribers(options_.channel, count + 1, {})) ++count;
  // Some that take another type have joined, too: they take bytes, and refuse them later.
  const std::size_t fitting = Fitting();
  subscribers_ = std::max(subscribers_, refusal_.empty() ? count : std::min(count, fitting));
}

bool Publishing::AwaitSubscribers() {
  const std::size_t known = Fitting();
  if (known == 0 && options_.latched) return true;
  const std::chrono::nanoseconds patience = options_.robot.Timeout(std::chrono::seconds(1));
  const bool waits = options_.once() || !options_.robot.timeout_s;  // Otherwise half of --timeout is for the messages.
  const auto deadline = std::chrono::steady_clock::now() + (waits ? patience : patience / 2);
  const Progress progress(robot_.surroundings().console, robot_.surroundings().pause,
                          "waiting for a subscriber of " + Visible(options_.channel), waits ? patience : patience / 2);
  constexpr auto kSlice = std::chrono::milliseconds(20);  // Ctrl-C must not wait longer.
  while (!robot_.session().WaitForSubscribers(options_.channel, std::max<std::size_t>(known, 1), kSlice) &&
         std::chrono::steady_clock::now() < deadline) {
    if (robot_.surroundings().pause.For({}) == Pause::End::kInterrupted) return false;
  }
  CountSubscribers();
  return true;
}

void Publishing::Publish(const MessageDocument& document, const yaml::Node& value) {
  const std::unique_ptr<google::protobuf::Message> message = type_.type->Read({});
  ReadMessage(document, value, *message);
  const auto bytes = std::make_shared<const std::string>(message->SerializePartialAsString());
  const Payload payload{AsBytes(*bytes), bytes};
  PublishStatus status = publish_(payload);
  const auto deadline = std::chrono::steady_clock::now() + options_.robot.Timeout(std::chrono::seconds(1));
  constexpr auto kSlice = std::chrono::milliseconds(50);
  while ((status == PublishStatus::kFull || status == PublishStatus::kTimedOut) &&
         std::chrono::steady_clock::now() < deadline &&
         robot_.surroundings().pause.For({}) != Pause::End::kInterrupted) {
    status = publish_.Wait(payload, std::min(deadline, std::chrono::steady_clock::now() + kSlice));
  }
  CountSubscribers();
  if (status == PublishStatus::kOk) {
    ++published_;
    bytes_ += bytes->size();
  } else if (robot_.surroundings().pause.signal() == 0) {
    const std::string what =
        fmt::format("Message {} was not published on {}: {}.", published_ + 1, options_.channel, MeaningOf(status));
    if (status == PublishStatus::kFull || status == PublishStatus::kTimedOut) options_.robot.GiveUp(what);
    throw Error(what);
  }
}

std::string Publishing::Sentence() const {
  return fmt::format("Published {} {} of {} on {} to {} {}.{}{}", published_, published_ == 1 ? "message" : "messages",
                     type_.schema.type_name, Visible(options_.channel), subscribers_,
                     subscribers_ == 1 ? "subscriber" : "subscribers", refusal_.empty() ? "" : " ", refusal_);
}

void Publishing::Report() const {
  Console& console = robot_.surroundings().console;
  if (options_.robot.style.json) {
    Json json;
    json.BeginObject().Member("channel", options_.channel).Member("type", type_.schema.type_name);
    json.Member("messages", published_).Member("bytes", bytes_);
    json.Member("subscribers", std::uint64_t{subscribers_}).EndObject();
    console.Line(json.text());
  } else if (console.interactive() && robot_.surroundings().pause.signal() == 0) {
    console.Line(Sentence() + (options_.latched ? " Late subscribers get the last one until Ctrl-C." : ""));
  }
}

class Pub final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"CHANNEL", "", "The channel", ValueKind::kChannel, {}, true}, options_.channel);
    arguments.Positional({"YAML", "", "The message, such as '{x: 1}'; without it all fields are unset"},
                         options_.message);
    arguments.Option("--type", "TYPE", options_.type, "Type of the message; without it the type of the channel",
                     ValueKind::kType);
    arguments.Option("--rate", "HZ", options_.rate, "Publish this often, until Ctrl-C or --count");
    arguments.Option("-n,--count", "N", options_.count, "Publish N messages; without --rate once a second");
    arguments.Flag("--latched", options_.latched, "Keep running, and give the last message to late subscribers");
    arguments.Option("--file", "FILE", options_.file,
                     "Publish each line of this file: a message as JSON, or a line of `hgros echo --json`; - is "
                     "standard input",
                     ValueKind::kFile);
    arguments.Flag("--as-recorded", options_.as_recorded, "Publish the lines of --file in their recorded rhythm");
    options_.types.Declare(arguments);
    options_.robot.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Publishes a message that is written as YAML or JSON. Before the first one it waits up to a second "
           "until all subscribers have joined. --timeout counts for the whole command: one message waits for "
           "subscribers until then, several wait half of it. \"now\" is the time at which a message is published. "
           "`hgros schema TYPE --template` writes a message to fill in.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros pub wish '{message: hello, level: INFO, timestamp: now}' --type foxglove.Log",
             "Publishes one message."},
            {"hgros pub wish '{message: again}' --rate 10 -n 5", "Publishes 5 messages, 10 a second."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  void CheckOptions() const;
  void PublishMessage(Publishing& publishing, const MessageDocument& document) const;
  void PublishFile(Publishing& publishing, Pause& pause) const;

  PubOptions options_;
};

void Pub::CheckOptions() const {
  if (options_.channel.starts_with("hgros/")) {
    throw UsageError("Channels that begin with \"hgros/\" belong to the library: a program cannot publish on them.");
  }
  if (!options_.file.empty() && !options_.message.empty()) {
    throw UsageError("--file gives the messages, so no message can be written in the command line.");
  }
  if (options_.as_recorded && options_.file.empty()) throw UsageError("--as-recorded needs --file.");
  if (options_.rate && (*options_.rate < 1e-6 || *options_.rate > 1e6)) {
    throw UsageError("--rate must be from 0.000001 to 1000000 Hz.");
  }
  if (options_.as_recorded && options_.rate) throw UsageError("--as-recorded and --rate exclude each other.");
}

void Pub::PublishMessage(Publishing& publishing, const MessageDocument& document) const {
  publishing.Publish(document, document.root());
  if (!options_.rate && !options_.count) return;
  const auto begin = std::chrono::steady_clock::now();
  const double period_ns = 1e9 / options_.rate.value_or(1);
  for (std::uint64_t turn = 1; !publishing.enough(); ++turn) {
    // After a pause, such as Ctrl-Z, the missed turns are not made up.
    const double due_ns = std::min(static_cast<double>(turn) * period_ns, 9e18);
    if (!publishing.SleepUntil(begin + std::chrono::nanoseconds(static_cast<std::int64_t>(due_ns)))) return;
    const std::chrono::duration<double, std::nano> passed = std::chrono::steady_clock::now() - begin;
    turn = std::max(turn, static_cast<std::uint64_t>(passed.count() / period_ns));
    publishing.Publish(document, document.root());
  }
}

const yaml::Node* MemberOf(const yaml::Node& object, std::string_view name) {
  const auto found = std::ranges::find_if(object.entries, [&](const auto& entry) { return entry.key->text == name; });
  return found == object.entries.end() ? nullptr : found->value;
}

// When a line of `hgros echo --json` was published; empty if it is a bare message.
std::optional<std::int64_t> RecordedTime(const yaml::Node& line) {
  const yaml::Node* time = MemberOf(line, "publish_time_ns");
  const yaml::Node* message = MemberOf(line, "message");
  if (time == nullptr || message == nullptr || message->kind != yaml::Node::Kind::kMap) return std::nullopt;
  std::int64_t time_ns = 0;
  const char* end = time->text.data() + time->text.size();
  const auto [stopped, error] = std::from_chars(time->text.data(), end, time_ns);
  if (error != std::errc() || stopped != end || time_ns < 0) return std::nullopt;
  return time_ns;
}

// The message of a line: all of it, or a member of what `hgros echo --json` wrote.
const yaml::Node& MessageIn(const MessageDocument& line, const std::string& type) {
  const yaml::Node& root = line.root();
  if (!RecordedTime(root)) {
    if (MemberOf(root, "publish_time_ns") != nullptr && MemberOf(root, "publisher") != nullptr) {
      throw ConfigError("This line of `hgros echo` has no whole message.", line.PositionOf(root),
                        "Record without --field, and a type that is known.");
    }
    return root;
  }
  const yaml::Node* recorded_type = MemberOf(root, "type");
  if (recorded_type != nullptr && recorded_type->text != type) {
    throw ConfigError("This message is of the type " + recorded_type->text + ", not " + type + ".",
                      line.PositionOf(*recorded_type), "Record each channel in a file of its own.");
  }
  return *MemberOf(root, "message");
}

// The type that the first line of the file names, if `hgros echo` wrote it; otherwise empty. A pipe is not read,
// because its first line would be lost.
std::string TypeInFile(const std::string& file, Pause& pause) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return {};
  LineReader lines(file, MessageDocument::kMostJsonBytes);
  std::optional<std::string_view> line = "";
  while (line && line->find_first_not_of(" \t\r") == std::string_view::npos) {
    line = lines.Next(pause, std::chrono::steady_clock::time_point::max());
  }
  if (!line) return {};
  const MessageDocument document = MessageDocument::ParseJson(*line, lines.name(), lines.number());
  const yaml::Node* type = RecordedTime(document.root()) ? MemberOf(document.root(), "type") : nullptr;
  return type == nullptr ? std::string() : type->text;
}

void Pub::PublishFile(Publishing& publishing, Pause& pause) const {
  LineReader lines(options_.file, MessageDocument::kMostJsonBytes);
  std::optional<SteadyTime> begin;
  std::int64_t first_ns = 0;
  while (!publishing.enough()) {
    const std::optional<std::string_view> line = lines.Next(pause, publishing.end());
    if (!line) return;
    if (line->find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const MessageDocument document = MessageDocument::ParseJson(*line, lines.name(), lines.number());
    const std::optional<std::int64_t> recorded = RecordedTime(document.root());
    if (options_.as_recorded && !recorded) {
      throw ConfigError("This line has no publish_time_ns, so --as-recorded cannot be used.",
                        {lines.name(), lines.number(), 0}, "Record it with `hgros echo --json`.");
    }
    if (!begin) {
      begin = std::chrono::steady_clock::now();
      first_ns = recorded.value_or(0);
    }
    std::chrono::nanoseconds due{0};
    if (options_.as_recorded)
      due = std::min<std::chrono::nanoseconds>(std::chrono::nanoseconds(*recorded - first_ns), kLongest);
    if (options_.rate) {
      due = std::chrono::nanoseconds(
          static_cast<std::int64_t>(std::min(static_cast<double>(publishing.published()) / *options_.rate, 9e9) * 1e9));
    }
    if (!publishing.SleepUntil(*begin + due)) return;
    publishing.Publish(document, MessageIn(document, publishing.type_name()));
  }
}

int Pub::Run(Surroundings& surroundings) {
  CheckOptions();
  std::optional<MessageDocument> document;
  if (options_.file.empty()) document = MessageDocument::Parse(options_.message, "message");
  const TypeFinder finder(options_.types);
  Robot robot(options_.robot, surroundings);
  const std::string recorded = options_.file.empty() ? "" : TypeInFile(options_.file, surroundings.pause);
  const ChannelType type = TypeOfChannel(robot, options_.robot, finder, options_.channel, options_.type, recorded);
  if (document) ReadMessage(*document, *type.type->Read({}));  // Its faults come before the channel is announced.
  Publishing publishing(options_, robot, type);
  if (!publishing.AwaitSubscribers()) return kDone;
  const bool heard = publishing.subscribers() > 0;
  const bool once = options_.once();
  if (!heard && !options_.latched) {
    const std::string nearest = NearestChannel(robot, options_.channel);
    const bool misspelled = !nearest.empty() && nearest != options_.channel;
    const std::string hint = !publishing.refusal().empty() ? " " + publishing.refusal()
                             : misspelled                  ? " Did you mean " + Visible(nearest) + "?"
                                                           : options_.robot.SendingHint();
    surroundings.console.Say("Nobody subscribes to " + Visible(options_.channel) +
                             (publishing.refusal().empty() ? "" : " with this type") +
                             (once ? ", so nobody gets the message." : " yet.") + hint);
    if (once) return options_.robot.timeout_s ? kTimedOut : kFailed;
  }
  try {
    if (document) {
      PublishMessage(publishing, *document);
    } else {
      PublishFile(publishing, surroundings.pause);
    }
  } catch (const Error&) {  // Its sentence is the last.
    if (publishing.published() > 0) surroundings.console.Say(publishing.Sentence());
    throw;
  }
  publishing.Report();
  if (options_.latched && surroundings.pause.signal() == 0) {
    if (surroundings.pause.SleepUntil(publishing.end())) return kTimedOut;
  }
  return kDone;
}

}  // namespace

std::unique_ptr<Command> MakePub() { return std::make_unique<Pub>(); }

}  // namespace hgros::cli
