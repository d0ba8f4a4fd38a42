#include <fmt/format.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "commands/commands.hpp"
#include "hgros/codec/dynamic_schema.hpp"
#include "messages/csv.hpp"
#include "messages/filter.hpp"
#include "messages/message_text.hpp"
#include "robot/overview.hpp"
#include "robot/robot.hpp"
#include "terminal/json.hpp"
#include "terminal/pause.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kQueue = 64;  // Messages that wait for the terminal; they may be images.

enum class Form { kYaml, kJson, kCsv, kRaw };

struct EchoOptions {
  std::vector<std::string> channels;
  bool csv = false;
  bool raw = false;
  std::vector<std::string> fields;
  std::optional<std::uint64_t> count;
  std::optional<double> rate;
  std::string filter;
  bool full = false;
};

// How the messages of one schema are read. Messages of one publisher share their schema object.
struct Reading {
  std::shared_ptr<const MessageSchema> schema;
  std::shared_ptr<const DynamicSchema> type;  // Null: the bytes are shown.
  std::optional<Filter> filter;
  std::vector<FieldPath> fields;
  std::optional<Csv> csv;
};

// Writes the messages of all channels. One message at a time, on the threads of the nodes.
class MessagePrinter {
 public:
  MessagePrinter(const EchoOptions& options, Form form, Surroundings& surroundings)
      : options_(options), form_(form), surroundings_(surroundings) {}

  void Print(const std::string& channel, const RawMessage& message, const MessageInfo& info);
  [[nodiscard]] bool done() const noexcept { return done_; }
  // After the last message.
  [[nodiscard]] std::uint64_t unreadable() const noexcept { return unreadable_; }
  [[nodiscard]] std::uint64_t printed() const noexcept { return printed_; }
  // With those that the filter refuses.
  [[nodiscard]] std::uint64_t received() const noexcept { return received_; }
  // Throws what went wrong while a message was printed.
  void Rethrow() const {
    if (fault_) std::rethrow_exception(fault_);
  }

 private:
  void PrintOne(const std::string& channel, const RawMessage& message, const MessageInfo& info);
  [[nodiscard]] Reading& ReadingOf(const std::string& channel, const std::shared_ptr<const MessageSchema>& schema);
  [[nodiscard]] bool IsTooSoon(const std::string& channel);
  void AppendHead(const std::string& channel, const MessageInfo& info);
  void AppendFields(const Reading& reading, const google::protobuf::Message& message);
  void AppendJson(const std::string& channel, const RawMessage& raw, const MessageInfo& info, const Reading& reading,
                  const google::protobuf::Message* message);
  void AppendBytes(const RawMessage& message);

  const EchoOptions& options_;
  const Form form_;
  Surroundings& surroundings_;
  std::mutex mutex_;
  std::deque<Reading> readings_;
  std::map<std::string, std::int64_t> last_ns_;
  std::string out_;
  std::string csv_header_;
  Json json_;
  std::uint64_t printed_ = 0;
  std::uint64_t unreadable_ = 0;
  std::uint64_t received_ = 0;
  std::exception_ptr fault_;
  std::atomic<bool> done_{false};
};

void MessagePrinter::Print(const std::string& channel, const RawMessage& message, const MessageInfo& info) {
  const std::scoped_lock lock(mutex_);
  if (done_) return;
  ++received_;
  try {
    PrintOne(channel, message, info);
  } catch (...) {
    fault_ = std::current_exception();
    done_ = true;
  }
  if (done_) surroundings_.pause.Wake();
}

Reading& MessagePrinter::ReadingOf(const std::string& channel, const std::shared_ptr<const MessageSchema>& schema) {
  for (Reading& known : readings_) {
    if (known.schema == schema || *known.schema == *schema) return known;
  }
  constexpr std::size_t kMostSchemas = 64;
  if (readings_.size() == kMostSchemas) readings_.pop_front();
  Reading& reading = readings_.emplace_back();
  reading.schema = schema;
  std::string fault;
  if (form_ != Form::kRaw) reading.type = DynamicSchema::Build(*schema, fault);
  if (reading.type == nullptr) {
    if (form_ != Form::kRaw) {
      surroundings_.console.Say("The messages of " + Visible(channel) + " are shown as bytes: " + Visible(fault));
    }
    return reading;
  }
  const google::protobuf::Descriptor& type = reading.type->descriptor();
  if (!options_.filter.empty()) reading.filter.emplace(options_.filter, type);
  for (const std::string& field : options_.fields) reading.fields.push_back(FieldPath::Parse(field, type));
  if (form_ == Form::kCsv) reading.csv.emplace(type, options_.fields);
  return reading;
}

bool MessagePrinter::IsTooSoon(const std::string& channel) {
  if (!options_.rate) return false;
  const std::int64_t now = MonotonicNow();
  std::int64_t& last = last_ns_[channel];
  if (last != 0 && static_cast<double>(now - last) * *options_.rate < 1e9) return true;
  last = now;
  return false;
}

void MessagePrinter::AppendHead(const std::string& channel, const MessageInfo& info) {
  constexpr std::int64_t kPerSecond = 1'000'000'000;
  if (options_.channels.size() == 1) return;
  const std::time_t seconds = info.publish_time_ns / kPerSecond;
  tm local{};
  localtime_r(&seconds, &local);
  out_ += surroundings_.console.Styled(
              Style::kDim, fmt::format("# {}  {:02}:{:02}:{:02}.{:06}", Visible(channel), local.tm_hour, local.tm_min,
                                       local.tm_sec, info.publish_time_ns % kPerSecond / 1000)) +
          "\n";
}

void MessagePrinter::AppendFields(const Reading& reading, const google::protobuf::Message& message) {
  const TextLimits limits = options_.full ? TextLimits::None() : TextLimits();
  if (reading.fields.empty()) AppendYaml(out_, {&message, nullptr, -1}, limits);
  for (std::size_t i = 0; i < reading.fields.size(); ++i) {
    const std::optional<FieldRef> place = reading.fields[i].Find(message);
    if (reading.fields.size() > 1) out_ += options_.fields[i] + ": ";
    if (!place) {
      out_ += "null\n";
      continue;
    }
    const bool nested = reading.fields.size() > 1 && (place->AsMessage() != nullptr || place->list());
    if (nested) out_.back() = '\n';
    AppendYaml(out_, *place, limits, nested ? 2 : 0);
  }
}

void MessagePrinter::AppendBytes(const RawMessage& message) {
  for (const std::byte byte : message.data.bytes)
    fmt::format_to(std::back_inserter(out_), "{:02x}", static_cast<unsigned>(byte));
  out_ += '\n';
}

void MessagePrinter::AppendJson(const std::string& channel, const RawMessage& raw, const MessageInfo& info,
                                const Reading& reading, const google::protobuf::Message* message) {
  json_.Clear();
  json_.BeginObject().Member("channel", channel).Member("type", raw.schema->type_name);
  json_.Member("publisher", SessionId{info.id.publisher}.ToString()).Member("sequence", info.id.sequence);
  json_.Member("publish_time_ns", info.publish_time_ns);
  if (message == nullptr) {
    json_.Member("base64", Base64(AsText(raw.data.bytes)));
  } else if (reading.fields.empty()) {
    WriteJson(json_.Key("message"), {message, nullptr, -1});
  } else {
    json_.Key("fields").BeginObject();
    for (std::size_t i = 0; i < reading.fields.size(); ++i) {
      json_.Key(options_.fields[i]);
      if (const std::optional<FieldRef> place = reading.fields[i].Find(*message)) {
        WriteJson(json_, *place);
      } else {
        json_.Null();
      }
    }
    json_.EndObject();
  }
  json_.EndObject();
  out_ += json_.text();
  out_ += '\n';
}

void MessagePrinter::PrintOne(const std::string& channel, const RawMessage& raw, const MessageInfo& info) {
  Reading& reading = ReadingOf(channel, raw.schema);
  std::unique_ptr<google::protobuf::Message> message;
  if (reading.type != nullptr) {
    std::string fault;
    message = reading.type->Read(raw.data.bytes, fault);
    if (message == nullptr) {
      if (unreadable_++ > 0) return;
      surroundings_.console.Say("A message of " + Visible(channel) + " cannot be read as " +
                                Visible(raw.schema->type_name) + ". " + fault);
      return;
    }
  } else if (!options_.filter.empty() || !options_.fields.empty() || form_ == Form::kCsv) {
    throw Error("--filter, --field and --csv need a type with fields. " + channel + " has none that is known.");
  }
  if (reading.filter && !reading.filter->Accepts(*message)) return;
  if (IsTooSoon(channel)) return;
  out_.clear();
  if (form_ == Form::kJson) {
    AppendJson(channel, raw, info, reading, message.get());
  } else if (form_ == Form::kCsv) {
    const bool several = options_.channels.size() > 1;
    const std::string header = (several ? "channel,publish_time_ns," : "publish_time_ns,") + reading.csv->Header();
    if (header != csv_header_) out_ += header + "\n";
    csv_header_ = header;
    if (several) out_ += CsvCell(Visible(channel)) + ",";
    out_ += std::to_string(info.publish_time_ns) + "," + reading.csv->Row(*message) + "\n";
  } else {
    AppendHead(channel, info);
    if (message == nullptr) {
      AppendBytes(raw);
    } else {
      AppendFields(reading, *message);
    }
    if (form_ == Form::kYaml && (reading.fields.size() != 1 || reading.fields.front().list())) out_ += "---\n";
  }
  surroundings_.console.Write(out_);
  ++printed_;
  if (options_.count && printed_ >= *options_.count) done_ = true;
}

class Echo final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"CHANNEL", "", "Channels to show", ValueKind::kChannel, {}, true}, options_.channels);
    arguments.Count(options_.count, "End after one message", "End after N messages");
    arguments.Option("--field", "PATH", options_.fields,
                     "Only this field, such as pose.position.x or ranges[0]; may be repeated");
    arguments.Option("--filter", "EXPR", options_.filter,
                     "Only messages for which this is true, such as 'level == \"ERROR\"'");
    arguments.Option("--rate", "HZ", options_.rate, "At most this often per channel");
    arguments.Flag("--csv", options_.csv, "Comma-separated values with a header");
    arguments.Flag("--raw", options_.raw, "The bytes of each message in hexadecimal");
    arguments.Flag("--full", options_.full, "Do not shorten long lists and texts");
    robot_options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Shows each message that is published on the channels, and the latched ones first. Any type can be shown: "
           "its "
           "description comes with the channel. YAML is shortened unless --full is given; JSON and CSV are complete.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros echo scan --once", "Shows the next message."},
            {"hgros echo odometry --field pose.position --json -n 100", "Writes a part of 100 messages as JSON."}};
  }

  int Run(Surroundings& surroundings) override;

 private:
  [[nodiscard]] std::string NoMessage(const Robot& robot) const;

  EchoOptions options_;
  RobotOptions robot_options_;
};

// Although somebody may publish.
std::string Echo::NoMessage(const Robot& robot) const {
  std::string text;
  for (const std::string& channel : options_.channels) text += (text.empty() ? "" : ", ") + Visible(channel);
  std::set<std::string> publishers;
  for (const KnownChannel& known : robot.Channels(true)) {
    if (std::ranges::find(options_.channels, known.name) == options_.channels.end()) continue;
    for (const ChannelUser& user : known.publishers) publishers.insert(Visible(ShortName(user, true)));
  }
  text = fmt::format("No message of {} came within {} s.", text, robot_options_.timeout_s.value_or(0));
  if (publishers.empty()) return text;
  return text + " " + fmt::format("{}", fmt::join(publishers, ", ")) +
         (publishers.size() == 1 ? " publishes" : " publish") + ", but sent none.";
}

int Echo::Run(Surroundings& surroundings) {
  if (options_.csv + options_.raw + robot_options_.style.json > 1) {
    throw UsageError("--json, --csv and --raw exclude each other.");
  }
  if (options_.raw && (!options_.filter.empty() || !options_.fields.empty())) {
    throw UsageError("--raw shows whole messages as bytes, so it cannot be used with --filter or --field.");
  }
  for (const std::string& field : options_.fields) FieldPath::RequireForm(field);
  const Form form = robot_options_.style.json ? Form::kJson
                    : options_.csv            ? Form::kCsv
                    : options_.raw            ? Form::kRaw
                                              : Form::kYaml;
  MessagePrinter printer(options_, form, surroundings);
  Robot robot(robot_options_, surroundings);
  std::vector<Subscription> subscriptions;
  const Queue queue = Queue::KeepLast(kQueue);
  for (const std::string& channel : options_.channels) {
    subscriptions.push_back(robot.session().FromAnyRaw(
        channel, Invoke::kSerial,
        [&printer, channel](const std::shared_ptr<const RawMessage>& message, const MessageInfo& info) {
          printer.Print(channel, *message, info);
        },
        {.name = "echo " + channel, .queue = queue}));
  }
  robot.SayUnpublished(options_.channels);
  const auto deadline = std::chrono::steady_clock::now() + robot_options_.Timeout(std::chrono::hours(24 * 365));
  Pause::End end = Pause::End::kWoken;
  while (!printer.done() && end == Pause::End::kWoken) end = surroundings.pause.Until(deadline);
  std::uint64_t dropped = 0;
  for (Subscription& subscription : subscriptions) {
    dropped += subscription.stats().dropped;
    subscription.Join();
  }
  printer.Rethrow();
  if (dropped > 0)
    surroundings.console.Say(
        fmt::format("{} messages came faster than they could be written, and are missing.", dropped));
  if (printer.unreadable() > 1) {
    surroundings.console.Say(fmt::format("{} messages could not be read.", printer.unreadable()));
  }
  if (end != Pause::End::kDeadline || printer.done()) return kDone;
  if (printer.received() == 0) {
    surroundings.console.Say(NoMessage(robot));
  } else if (printer.printed() == 0 && !options_.filter.empty()) {
    surroundings.console.Say(fmt::format("{} messages came, but --filter accepted none.", printer.received()));
  }
  return kTimedOut;
}

}  // namespace

std::unique_ptr<Command> MakeEcho() { return std::make_unique<Echo>(); }

}  // namespace hgros::cli
