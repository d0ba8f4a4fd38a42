// Recordings on the disk.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "commands/commands.hpp"
#include "hgros/record/mcap_reader.hpp"
#include "hgros/record/mcap_writer.hpp"
#include "terminal/json.hpp"
#include "terminal/pause.hpp"
#include "terminal/progress.hpp"
#include "terminal/sheet.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kShownFaults = 10;
constexpr std::uint64_t kBetweenLooks = 4096;  // Records until it is looked whether the user has ended the command.

const std::string& TopicOf(const mcap::Reader& reader, std::uint16_t channel) {
  static const std::string unknown = "an unknown channel";
  const auto found = reader.channels().find(channel);
  return found == reader.channels().end() ? unknown : found->second.topic;
}

std::string TextOf(const mcap::Fault& fault) {
  return fault.messages == 0 ? Visible(fault.what)
                             : fmt::format("{} Messages lost: {}.", Visible(fault.what), fault.messages);
}

void SayFaults(Console& console, const mcap::Reader& reader, const std::string& file) {
  for (std::size_t i = 0; i < std::min(kShownFaults, reader.faults().size()); ++i) {
    console.Say(TextOf(reader.faults()[i]));
  }
  if (reader.fault_count() > kShownFaults) {
    console.Say(fmt::format("{} more places cannot be read. `hgros bag check {}` lists them.",
                            reader.fault_count() - kShownFaults, Visible(file)));
  }
}

// A command for one recording.
class BagCommand : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"FILE", "", "The recording", ValueKind::kFile, {}, true}, file_);
    arguments.Flag("--json", style_.json, "One JSON object per line");
  }

 protected:
  std::string file_;
  OutputStyle style_;
};

class BagInfo final : public BagCommand {
 public:
  [[nodiscard]] std::string Description() const override {
    return "Shows what is in a recording: its channels with types, numbers of messages and mean rates, its time, size "
           "and compression, and what is attached. It reads only the summary at the end of the file, if there is one.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros bag info run.mcap", "Shows what was recorded."},
            {"hgros bag info run.mcap --json", "Writes the same as one JSON object."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  static void AddFacts(Sheet& sheet, const mcap::Reader& reader);
  static void AddTables(Sheet& sheet, const mcap::Reader& reader);
};

Cell TimeCell(std::uint64_t ns) {
  const auto time = static_cast<std::int64_t>(ns);
  return {ns, fmt::format("{:%Y-%m-%d} {}", fmt::localtime(static_cast<std::time_t>(time / 1'000'000'000)),
                          TimeOfDay(time))};
}

void BagInfo::AddFacts(Sheet& sheet, const mcap::Reader& reader) {
  const mcap::Statistics& statistics = reader.statistics();
  sheet.Fact("size_bytes", "Size", {reader.size_bytes(), BytesText(static_cast<double>(reader.size_bytes()), false)});
  if (statistics.message_count > 0) {
    const std::uint64_t duration = statistics.message_end_time - statistics.message_start_time;
    sheet.Fact("start_ns", "Start", TimeCell(statistics.message_start_time));
    sheet.Fact("end_ns", "End", TimeCell(statistics.message_end_time));
    sheet.Fact("duration_ns", "Duration", {duration, DurationText(static_cast<std::int64_t>(duration), false)});
  }
  sheet.Fact("messages", "Messages", statistics.message_count);
  std::set<std::string> compressions;
  double stored = 0;
  double original = 0;
  for (const mcap::ChunkIndex& chunk : reader.chunks()) {
    compressions.insert(chunk.compression.empty() ? "none" : Visible(chunk.compression));
    stored += static_cast<double>(chunk.compressed_size);
    original += static_cast<double>(chunk.uncompressed_size);
  }
  std::string chunks = std::to_string(reader.chunks().size());
  if (stored > 0 && compressions != std::set<std::string>{"none"}) {
    chunks +=
        fmt::format(" ({}, {:.0f} % of the original size)", fmt::join(compressions, " and "), 100 * stored / original);
  }
  sheet.Fact("chunks", "Chunks", {std::uint64_t{reader.chunks().size()}, chunks});
  sheet.Fact("compressions", "", std::vector<std::string>(compressions.begin(), compressions.end()));
  sheet.Fact("library", "Written by", reader.header().library);
  sheet.Fact("profile", "Profile", reader.header().profile);
  sheet.Fact("has_summary", "", reader.has_summary());
}

void BagInfo::AddTables(Sheet& sheet, const mcap::Reader& reader) {
  const mcap::Statistics& statistics = reader.statistics();
  const double seconds = static_cast<double>(statistics.message_end_time - statistics.message_start_time) / 1e9;
  Sheet::Table channels{"channels",
                        {{"channel", "CHANNEL"},
                         {"type", "TYPE"},
                         {"encoding", "ENCODING"},
                         {"messages", "MESSAGES", true},
                         {"rate_hz", "RATE", true}},
                        {}};
  std::vector<const mcap::Channel*> sorted;
  for (const auto& [id, channel] : reader.channels()) sorted.push_back(&channel);
  std::ranges::stable_sort(sorted, {}, &mcap::Channel::topic);
  for (const mcap::Channel* channel : sorted) {
    const auto schema = reader.schemas().find(channel->schema_id);
    const auto count = statistics.channel_message_counts.find(channel->id);
    const std::uint64_t messages = count == statistics.channel_message_counts.end() ? 0 : count->second;
    const double rate = messages > 1 && seconds > 0 ? static_cast<double>(messages) / seconds : 0;
    channels.rows.push_back({channel->topic, schema == reader.schemas().end() ? Cell() : Cell(schema->second.name),
                             channel->message_encoding, messages,
                             rate > 0 ? Cell(rate, RateText(rate, false)) : Cell(0.0, "-")});
  }
  sheet.Add(std::move(channels));
  Sheet::Table attachments{
      "attachments", {{"name", "ATTACHMENT"}, {"media_type", "MEDIA TYPE"}, {"size_bytes", "SIZE", true}}, {}};
  for (const mcap::AttachmentIndex& one : reader.attachments()) {
    attachments.rows.push_back(
        {one.name, one.media_type, {one.data_size, BytesText(static_cast<double>(one.data_size), false)}});
  }
  sheet.Add(std::move(attachments));
  Sheet::Table metadata{"metadata", {{"name", "METADATA"}}, {}};
  for (const mcap::MetadataIndex& one : reader.metadata()) metadata.rows.push_back({one.name});
  sheet.Add(std::move(metadata));
}

int BagInfo::Run(Surroundings& surroundings) {
  const mcap::Reader reader(file_);
  Sheet sheet("recording", file_);
  AddFacts(sheet, reader);
  AddTables(sheet, reader);
  sheet.Write(surroundings.console, style_);
  SayFaults(surroundings.console, reader, file_);
  if (!reader.has_summary()) {
    surroundings.console.Say(
        Visible(file_) +
        " has no usable summary, so all of it was read. `hgros bag recover` writes a file that has "
        "one.");
  }
  return kDone;
}

class BagCheck final : public BagCommand {
 public:
  [[nodiscard]] std::string Description() const override {
    return "Reads all of a recording, compares it with its checksums and with the numbers of its summary, and lists "
           "the "
           "places that cannot be read. It is silent about a whole file when its output is no terminal.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros bag check run.mcap", "Lists what is damaged."},
            {"hgros bag check run.mcap --json", "Writes one JSON object for each damaged place."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  // By place.
  using Faults = std::map<std::uint64_t, mcap::Fault>;
  // Returns how many messages each channel has. Empty if the user has ended the command.
  std::optional<std::map<std::uint16_t, std::uint64_t>> ReadAll(Surroundings& surroundings, Faults& faults) const;
  void Write(Console& console, const Faults& faults) const;
};

std::optional<std::map<std::uint16_t, std::uint64_t>> BagCheck::ReadAll(Surroundings& surroundings,
                                                                        Faults& faults) const {
  const Progress progress(surroundings.console, surroundings.pause, "reading " + Visible(file_));
  std::map<std::uint16_t, std::uint64_t> messages;
  mcap::Records records(file_);
  std::uint64_t count = 0;
  for (mcap::RecordView record; records.Next(record);) {
    if (record.opcode == mcap::Opcode::kMessage && record.content.size() >= sizeof(std::uint16_t)) {
      ++messages[static_cast<std::uint16_t>(std::to_integer<unsigned>(record.content[0]) |
                                            std::to_integer<unsigned>(record.content[1]) << 8U)];
    }
    if (++count % kBetweenLooks == 0 && surroundings.pause.For({}) == Pause::End::kInterrupted) return std::nullopt;
  }
  for (const mcap::Fault& fault : records.faults()) faults.emplace(fault.offset, fault);
  return messages;
}

void BagCheck::Write(Console& console, const Faults& faults) const {
  for (const auto& [offset, fault] : faults) {
    if (!style_.json) {
      console.Line(TextOf(fault));
      continue;
    }
    Json json;
    json.BeginObject().Member("offset_bytes", offset).Member("what", fault.what).Member("messages", fault.messages);
    console.Line(json.EndObject().text());
  }
}

int BagCheck::Run(Surroundings& surroundings) {
  mcap::Reader reader(file_);
  Faults faults;
  const auto messages = ReadAll(surroundings, faults);
  if (!messages) return kDone;
  if (!faults.empty()) {  // The reader knows how many messages are lost there, once it has tried to read them.
    mcap::Messages all = reader.Select();
    for (mcap::Message message; all.Next(message);) {
      if (surroundings.pause.signal() != 0) return kDone;
    }
  }
  for (const mcap::Fault& fault : reader.faults()) faults.insert_or_assign(fault.offset, fault);
  const auto try_to_read = [&](const auto& index) {
    try {
      (void)reader.Read(index);
    } catch (const Error& error) {
      faults.emplace(index.offset, mcap::Fault{index.offset, error.what(), 0});
    }
  };
  std::ranges::for_each(reader.attachments(), try_to_read);
  std::ranges::for_each(reader.metadata(), try_to_read);
  std::uint64_t all = 0;
  for (const auto& [channel, count] : *messages) all += count;
  if (faults.empty() && all != reader.statistics().message_count) {
    faults.emplace(0, mcap::Fault{0, fmt::format("The summary counts {} messages, and there are {}.",
                                                 reader.statistics().message_count, all)});
  }
  for (const auto& [channel, counted] : reader.statistics().channel_message_counts) {
    const auto found = messages->find(channel);
    const std::uint64_t count = found == messages->end() ? 0 : found->second;
    if (!faults.empty() || count == counted) continue;
    faults.emplace(0, mcap::Fault{0, fmt::format("The summary counts {} messages of {}, and there are {}.", counted,
                                                 TopicOf(reader, channel), count)});
  }
  Write(surroundings.console, faults);
  if (!faults.empty()) return kFailed;
  if (surroundings.console.interactive() && !style_.json) {
    surroundings.console.Line(
        fmt::format("Nothing is wrong. Messages: {}, channels: {}.", all, reader.channels().size()));
  }
  return kDone;
}

class BagRecover final : public BagCommand {
 public:
  void Declare(Arguments& arguments) override {
    BagCommand::Declare(arguments);
    arguments.Option("-o,--output", "FILE", output_, "The new file; without it FILE with .recovered before its ending",
                     ValueKind::kFile);
  }
  [[nodiscard]] std::string Description() const override {
    return "Writes all that can be read of a recording into a new one with a summary: messages in their order, "
           "schemas, channels, attachments and metadata. What is lost is said. The old file stays.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros bag recover run.mcap", "Writes run.recovered.mcap."},
            {"hgros bag recover run.mcap -o whole.mcap --json", "Writes what was done as JSON."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  // False if the user has ended the command.
  bool Copy(Surroundings& surroundings, mcap::Reader& reader, mcap::Writer& writer);

  std::string output_;
  std::uint64_t others_lost_ = 0;  // Attachments and metadata.
};

mcap::Compression CompressionOf(const mcap::Reader& reader) {
  if (reader.chunks().empty()) return mcap::Compression::kNone;
  const std::string& name = reader.chunks().front().compression;
  if (name == "lz4") return mcap::Compression::kLz4;
  return name == "zstd" ? mcap::Compression::kZstd : mcap::Compression::kNone;
}

bool BagRecover::Copy(Surroundings& surroundings, mcap::Reader& reader, mcap::Writer& writer) {
  const Progress progress(surroundings.console, surroundings.pause, "writing " + Visible(output_));
  std::map<std::uint16_t, std::uint16_t> schemas{{0, 0}};
  for (const auto& [id, schema] : reader.schemas()) {
    schemas[id] = writer.AddSchema(schema.name, schema.encoding, schema.data);
  }
  std::map<std::uint16_t, std::uint16_t> channels;
  for (const auto& [id, channel] : reader.channels()) {
    const auto schema = schemas.find(channel.schema_id);
    channels[id] = writer.AddChannel(channel.topic, channel.message_encoding,
                                     schema == schemas.end() ? std::uint16_t{0} : schema->second, channel.metadata);
  }
  mcap::Selection all;
  all.order = mcap::Order::kFile;
  mcap::Messages messages = reader.Select(all);
  std::uint64_t count = 0;
  for (mcap::Message message; messages.Next(message);) {
    message.channel_id = channels.at(message.channel_id);
    writer.Write(message);
    if (++count % kBetweenLooks == 0 && surroundings.pause.For({}) == Pause::End::kInterrupted) return false;
  }
  const auto copy = [&](const auto& index) {
    auto read = [&] {
      try {
        return std::optional(reader.Read(index));
      } catch (const Error& error) {
        ++others_lost_;
        surroundings.console.Say(Visible(error.what()));
        return decltype(std::optional(reader.Read(index)))();
      }
    }();
    if (read) writer.Write(*read);
  };
  std::ranges::for_each(reader.attachments(), copy);
  std::ranges::for_each(reader.metadata(), copy);
  return true;
}

int BagRecover::Run(Surroundings& surroundings) {
  if (output_.empty()) {
    std::filesystem::path path(file_);
    output_ = path.replace_extension(".recovered" + path.extension().string()).string();
  }
  mcap::Reader reader(file_);
  mcap::WriterOptions options;
  options.profile = reader.header().profile;
  options.compression = CompressionOf(reader);
  mcap::Writer writer(output_, options);
  struct Unfinished {  // A part of the messages is no recording of them.
    ~Unfinished() {
      std::error_code ignored;
      if (!file.empty()) std::filesystem::remove(file, ignored);
    }
    std::string file;
  } unfinished{output_};
  if (!Copy(surroundings, reader, writer)) return kDone;
  writer.Close();
  unfinished.file.clear();

  SayFaults(surroundings.console, reader, file_);
  std::uint64_t lost = 0;
  for (const mcap::Fault& fault : reader.faults()) lost += fault.messages;
  if (style_.json) {
    Json json;
    json.BeginObject().Member("file", output_).Member("messages", writer.statistics().message_count);
    json.Member("faults", reader.fault_count() + others_lost_).Member("messages_lost", lost).EndObject();
    surroundings.console.Line(json.text());
  } else if (surroundings.console.interactive()) {
    surroundings.console.Line(fmt::format("Wrote {}: {} messages on {} channels, {}.", Visible(output_),
                                          writer.statistics().message_count, reader.channels().size(),
                                          BytesText(static_cast<double>(writer.size_bytes()), false)));
  }
  return kDone;
}

}  // namespace

std::unique_ptr<Command> MakeBagCheck() { return std::make_unique<BagCheck>(); }
std::unique_ptr<Command> MakeBagInfo() { return std::make_unique<BagInfo>(); }
std::unique_ptr<Command> MakeBagRecover() { return std::make_unique<BagRecover>(); }

}  // namespace hgros::cli
