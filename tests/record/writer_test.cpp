#include <gmock/gmock.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "hgros/record/mcap_reader.hpp"
#include "hgros/record/mcap_writer.hpp"
#include "support/error_of.hpp"
#include "support/scratch_folder.hpp"
#include "support/seed.hpp"

namespace hgros::mcap::writer_test {
namespace {

using testing::HasSubstr;

// A message that owns its data.
struct Written {
  std::uint16_t channel;
  std::uint32_t sequence;
  std::uint64_t log_time;
  std::uint64_t publish_time;
  std::string data;
  bool operator==(const Written&) const = default;
};

std::vector<Written> ReadAll(Reader& reader, Selection selection = {}) {
  std::vector<Written> result;
  Messages messages = reader.Select(std::move(selection));
  for (Message message; messages.Next(message);) {
    result.push_back({message.channel_id, message.sequence, message.log_time, message.publish_time,
                      std::string(AsText(message.data))});
  }
  return result;
}

// Writes random messages, and remembers them.
class RandomFile {
 public:
  RandomFile(const std::filesystem::path& path, std::mt19937_64& random) : random_(random), path_(path) {
    options_.chunks = Below(4) != 0;
    options_.chunk_bytes = 200 + Below(20'000);
    options_.compression = static_cast<Compression>(Below(3));
    options_.crc = Below(4) != 0;
    options_.message_index = Below(2) != 0;
    options_.chunk_index = Below(4) != 0;
    options_.statistics = Below(4) != 0;
    options_.repeat_schemas = Below(4) != 0;
    options_.repeat_channels = Below(4) != 0;
    options_.attachment_index = Below(4) != 0;
    options_.metadata_index = Below(4) != 0;
    options_.summary_offsets = Below(2) != 0;
    Writer writer(path, options_);
    for (int i = 0; i < 600; ++i) Step(writer);
    writer.Close();
    statistics = writer.statistics();
  }

  // What a reader selects, computed as simply as possible.
  [[nodiscard]] std::vector<Written> Selected(const Selection& selection) const {
    std::vector<Written> result;
    for (const Written& message : messages) {
      const bool has_channel = !selection.channels || selection.channels->contains(message.channel);
      if (has_channel && message.log_time >= selection.start && message.log_time <= selection.end)
        result.push_back(message);
    }
    if (selection.order == Order::kLogTime) {
      std::ranges::stable_sort(result, {}, &Written::log_time);
    }
    return result;
  }

  Selection AnySelection() {
    Selection selection;
    if (Below(2) != 0) {
      selection.channels.emplace();
      for (std::size_t i = 0; i < channels.size(); ++i) {
        if (Below(2) != 0) selection.channels->insert(static_cast<std::uint16_t>(i + 1));
      }
    }
    if (Below(2) != 0) selection.start = Below(time_ + 10);
    if (Below(2) != 0) selection.end = selection.start + Below(time_ + 10);
    if (Below(2) != 0) selection.order = Order::kFile;
    return selection;
  }

  std::vector<Written> messages;
  std::vector<Schema> schemas;
  std::vector<Channel> channels;
  std::vector<Attachment> attachments;
  std::vector<Metadata> metadata;
  Statistics statistics;

 private:
  std::uint64_t Below(std::uint64_t bound) { return random_() % bound; }
  std::string Text(std::size_t size) {
    std::string text(size, '\0');
    for (char& c : text) c = static_cast<char>(Below(7) == 0 ? Below(256) : 'a');
    return text;
  }

  void Step(Writer& writer) {
    const std::uint64_t kind = Below(100);
    if (kind == 0 || schemas.empty()) {
      Schema schema{0, Text(5), "protobuf", Text(50)};
      schema.id = writer.AddSchema(schema.name, schema.encoding, schema.data);
      schemas.push_back(std::move(schema));
    } else if (kind < 4 || channels.empty()) {
      Channel channel{
          0, static_cast<std::uint16_t>(Below(schemas.size() + 1)), Text(8), "protobuf", {{Text(2), Text(3)}}};
      channel.id = writer.AddChannel(channel.topic, channel.message_encoding, channel.schema_id, channel.metadata);
      channels.push_back(std::move(channel));
    } else if (kind == 5) {
      attachments.push_back({Below(100), Below(100), Text(4), "text/plain", Text(Below(300))});
      writer.Write(attachments.back());
    } else if (kind == 6) {
      metadata.push_back({Text(4), {{"key", Text(20)}}});
      writer.Write(metadata.back());
    } else if (kind == 7) {
      writer.Flush();
    } else {
      time_ += Below(3);
      const std::uint64_t log_time = Below(5) == 0 ? Below(time_ + 1) : time_;
      const std::size_t size = Below(50) == 0 ? 70'000 + Below(40'000) : Below(300);
      messages.push_back({static_cast<std::uint16_t>(1 + Below(channels.size())),
                          static_cast<std::uint32_t>(messages.size()), log_time, Below(1000), Text(size)});
      const Written& message = messages.back();
      writer.Write(
          Message{message.channel, message.sequence, message.log_time, message.publish_time, AsBytes(message.data)});
    }
  }

  std::mt19937_64& random_;
  std::filesystem::path path_;
  WriterOptions options_;
  std::uint64_t time_ = 0;
};

template <class Record>
std::vector<Record> Values(const std::map<std::uint16_t, Record>& records) {
  std::vector<Record> values;
  for (const auto& [id, record] : records) values.push_back(record);
  return values;
}

void ExpectSame(RandomFile& file, Reader& reader) {
  EXPECT_EQ(Values(reader.schemas()), file.schemas);
  EXPECT_EQ(Values(reader.channels()), file.channels);
  Statistics statistics = reader.statistics();
  EXPECT_EQ(statistics, file.statistics);
  ASSERT_EQ(reader.attachments().size(), file.attachments.size());
  for (std::size_t i = 0; i < file.attachments.size(); ++i) {
    EXPECT_EQ(reader.Read(reader.attachments()[i]), file.attachments[i]);
    EXPECT_EQ(reader.attachments()[i].name, file.attachments[i].name);
  }
  ASSERT_EQ(reader.metadata().size(), file.metadata.size());
  for (std::size_t i = 0; i < file.metadata.size(); ++i) EXPECT_EQ(reader.Read(reader.metadata()[i]), file.metadata[i]);
  EXPECT_TRUE(ReadAll(reader) == file.Selected({}));
  for (int i = 0; i < 5; ++i) {
    const Selection selection = file.AnySelection();
    EXPECT_TRUE(ReadAll(reader, selection) == file.Selected(selection));
  }
}

TEST(McapFile, IsReadAsItWasWrittenWithAndWithoutItsSummary) {
  std::mt19937_64 random(test::Seed());
  for (int round = 0; round < test::Rounds(20, 200); ++round) {
    SCOPED_TRACE(round);
    const test::ScratchFolder folder;
    RandomFile file(folder / "whole.mcap", random);
    std::uint64_t data_end = 0;
    {
      Reader reader(folder / "whole.mcap");
      ExpectSame(file, reader);
      EXPECT_EQ(reader.fault_count(), 0U);
      Records records(folder / "whole.mcap");
      for (RecordView record; records.Next(record);) {
        if (record.opcode == Opcode::kDataEnd) data_end = record.offset;
      }
      EXPECT_TRUE(records.faults().empty());
    }
    ASSERT_NE(data_end, 0U);
    std::filesystem::resize_file(folder / "whole.mcap", data_end);
    Reader reader(folder / "whole.mcap");
    EXPECT_FALSE(reader.has_summary());
    EXPECT_EQ(reader.fault_count(), 1U);  // The missing end.
    ExpectSame(file, reader);
  }
}

TEST(McapFile, IsReadInOrderThoughAllItsChunksOverlapAndDoNotFitIntoMemory) {
  const test::ScratchFolder folder;
  constexpr std::uint64_t kChunks = 12;
  constexpr std::uint64_t kMessages = 30;
  {
    WriterOptions options;
    options.compression = Compression::kLz4;
    options.chunk_bytes = std::size_t{1} << 30;
    Writer writer(folder / "a.mcap", options);
    writer.AddChannel("a", "", 0);
    const std::string data(330'000, 'x');
    for (std::uint64_t chunk = 0; chunk < kChunks; ++chunk) {
      for (std::uint64_t i = 0; i < kMessages; ++i) {
        writer.Write(Message{1, static_cast<std::uint32_t>(chunk), i * kChunks + chunk, 0, AsBytes(data)});
      }
      writer.Flush();
    }
  }
  Reader reader(folder / "a.mcap");
  Messages messages = reader.Select();
  std::uint64_t expected = 0;
  for (Message message; messages.Next(message); ++expected) {
    ASSERT_EQ(message.log_time, expected);
    ASSERT_EQ(message.sequence, expected % kChunks);
  }
  EXPECT_EQ(expected, kChunks * kMessages);
}

TEST(McapFile, HasAllIdsBothBytesAllow) {
  const test::ScratchFolder folder;
  Writer writer(folder / "a.mcap");
  for (int i = 1; i <= 65'535; ++i) ASSERT_EQ(writer.AddChannel("a", "", 0), i);
  EXPECT_THAT(test::ErrorOf([&] { writer.AddChannel("a", "", 0); }), HasSubstr("Begin another file."));
  writer.Write(Message{65'535, 0, 1, 1, {}});
  writer.Close();
  Reader reader(folder / "a.mcap");
  EXPECT_EQ(reader.channels().size(), 65'535U);
  EXPECT_EQ(ReadAll(reader).size(), 1U);
}

TEST(McapWriter, RefusesAFileThatExistsAndAFolderThatDoesNot) {
  const test::ScratchFolder folder;
  folder.Write("a.mcap", "mine");
  EXPECT_THAT(test::ErrorOf([&] { Writer(folder / "a.mcap"); }), HasSubstr("Give another name"));
  EXPECT_EQ(folder.Read("a.mcap"), "mine");
  EXPECT_THAT(test::ErrorOf([&] { Writer(folder / "no/a.mcap"); }), HasSubstr("Create the folder first."));
}

TEST(McapWriter, RefusesWhatIsNotAnnounced) {
  const test::ScratchFolder folder;
  Writer writer(folder / "a.mcap");
  EXPECT_NE(test::ErrorOf([&] { writer.AddChannel("a", "", 1); }), "");
  EXPECT_NE(test::ErrorOf([&] { writer.Write(Message{1, 0, 0, 0, {}}); }), "");
  writer.Close();
  EXPECT_NE(test::ErrorOf([&] { writer.AddSchema("a", "b", "c"); }), "");
}

// Files of this process cannot grow beyond a size.
class SizeLimit {
 public:
  explicit SizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  SizeLimit(const SizeLimit&) = delete;
  SizeLimit& operator=(const SizeLimit&) = delete;
  ~SizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(McapWriter, GoesOnWhenThereIsRoomAgain) {
  const test::ScratchFolder folder;
  WriterOptions options;
  options.chunk_bytes = 100'000;
  Writer writer(folder / "a.mcap", options);
  writer.AddChannel("a", "", 0);
  const std::string small(1'000, 's');
  const std::string large(150'000, 'l');  // Written without a copy.
  std::uint32_t accepted = 0;
  int refused = 0;
  {
    const SizeLimit limit(1'000'000);
    for (int i = 0; i < 2'000; ++i) {
      const std::string& data = i % 10 == 0 ? large : small;
      const std::string error = test::ErrorOf([&] { writer.Write(Message{1, accepted, accepted, 0, AsBytes(data)}); });
      if (error.empty()) {
        ++accepted;
      } else {
        ++refused;
        ASSERT_THAT(error, HasSubstr("cannot be written"));
      }
    }
    EXPECT_NE(test::ErrorOf([&] { writer.Close(); }), "");
  }
  EXPECT_GT(refused, 0);
  for (int i = 0; i < 200; ++i) writer.Write(Message{1, accepted, accepted++, 0, AsBytes(small)});
  writer.Close();
  Reader reader(folder / "a.mcap");
  EXPECT_TRUE(reader.has_summary());
  EXPECT_EQ(reader.statistics().message_count, accepted);
  std::uint32_t expected = 0;
  for (const Written& message : ReadAll(reader)) ASSERT_EQ(message.sequence, expected++);
  EXPECT_EQ(expected, accepted);
  EXPECT_EQ(reader.fault_count(), 0U);
}

TEST(McapReader, RefusesWhatIsNoRecording) {
  const test::ScratchFolder folder;
  folder.Write("a.bag", "#ROSBAG V2.0\n");
  folder.Write("empty", "");
  EXPECT_THAT(test::ErrorOf([&] { Reader(folder / "a.bag"); }), HasSubstr("is not an MCAP file"));
  EXPECT_THAT(test::ErrorOf([&] { Reader(folder / "empty"); }), HasSubstr("is not an MCAP file"));
  EXPECT_THAT(test::ErrorOf([&] { Reader reader(folder.path()); }), HasSubstr("is not an MCAP file"));
  EXPECT_THAT(test::ErrorOf([&] { Reader(folder / "none"); }), HasSubstr("No such file"));
}

}  // namespace
}  // namespace hgros::mcap::writer_test
