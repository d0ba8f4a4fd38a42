// The conformance cases of MCAP: pairs of a file and the records in it, as JSON.
#include <gtest/gtest.h>
#include <rapidjson/document.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "hgros/record/mcap_reader.hpp"
#include "hgros/record/mcap_writer.hpp"
#include "record/record_bytes.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::mcap::conformance_test {
namespace {

using Json = rapidjson::Value;

std::string Contents(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// One record of a case: its fields by name.
class Expected {
 public:
  explicit Expected(const Json& record) {
    for (const Json& field : record["fields"].GetArray()) fields_.emplace(field[0].GetString(), &field[1]);
  }
  [[nodiscard]] std::uint64_t Number(const char* name) const { return std::stoull(fields_.at(name)->GetString()); }
  [[nodiscard]] std::string Text(const char* name) const { return fields_.at(name)->GetString(); }
  [[nodiscard]] std::string Data() const {
    std::string bytes;
    for (const Json& byte : fields_.at("data")->GetArray()) bytes += static_cast<char>(std::stoi(byte.GetString()));
    return bytes;
  }
  [[nodiscard]] std::map<std::string, std::string> Texts(const char* name) const {
    std::map<std::string, std::string> texts;
    for (const auto& member : fields_.at(name)->GetObject())
      texts.emplace(member.name.GetString(), member.value.GetString());
    return texts;
  }
  [[nodiscard]] std::map<std::uint16_t, std::uint64_t> Numbers(const char* name) const {
    std::map<std::uint16_t, std::uint64_t> numbers;
    for (const auto& [key, value] : Texts(name)) numbers.emplace(std::stoi(key), std::stoull(value));
    return numbers;
  }

 private:
  std::map<std::string, const Json*> fields_;
};

std::uint16_t Id(const Expected& record, const char* name) { return static_cast<std::uint16_t>(record.Number(name)); }
std::uint32_t Number32(const Expected& record, const char* name) {
  return static_cast<std::uint32_t>(record.Number(name));
}

using mcap::Append;
void Append(Buffer& out, const Message& message) {
  AppendMessageHead(out, message);
  out.insert(out.end(), message.data.begin(), message.data.end());
}

// The records as bytes: equal bytes are equal records.
Buffer BytesOf(const std::string& type, const Expected& record) {
  Buffer out;
  if (type == "Header") {
    Append(out, Header{record.Text("profile"), record.Text("library")});
  } else if (type == "Schema") {
    Append(out, Schema{Id(record, "id"), record.Text("name"), record.Text("encoding"), record.Data()});
  } else if (type == "Channel") {
    Append(out, Channel{Id(record, "id"), Id(record, "schema_id"), record.Text("topic"),
                        record.Text("message_encoding"), record.Texts("metadata")});
  } else if (type == "Message") {
    const std::string data = record.Data();
    Append(out, Message{Id(record, "channel_id"), Number32(record, "sequence"), record.Number("log_time"),
                        record.Number("publish_time"), AsBytes(data)});
  } else if (type == "Attachment") {
    Append(out,
           Attachment{record.Number("log_time"), record.Number("create_time"), record.Text("name"),
                      record.Text("media_type"), record.Data()},
           true);
  } else if (type == "Metadata") {
    Append(out, Metadata{record.Text("name"), record.Texts("metadata")});
  } else if (type == "Statistics") {
    Append(out,
           Statistics{record.Number("message_count"), Id(record, "schema_count"), Number32(record, "channel_count"),
                      Number32(record, "attachment_count"), Number32(record, "metadata_count"),
                      Number32(record, "chunk_count"), record.Number("message_start_time"),
                      record.Number("message_end_time"), record.Numbers("channel_message_counts")});
  } else if (type == "ChunkIndex") {
    Append(out, ChunkIndex{record.Number("message_start_time"), record.Number("message_end_time"),
                           record.Number("chunk_start_offset"), record.Number("chunk_length"),
                           record.Numbers("message_index_offsets"), record.Number("message_index_length"),
                           record.Text("compression"), record.Number("compressed_size"),
                           record.Number("uncompressed_size")});
  } else if (type == "AttachmentIndex") {
    Append(out, AttachmentIndex{record.Number("offset"), record.Number("length"), record.Number("log_time"),
                                record.Number("create_time"), record.Number("data_size"), record.Text("name"),
                                record.Text("media_type")});
  } else if (type == "MetadataIndex") {
    Append(out, MetadataIndex{record.Number("offset"), record.Number("length"), record.Text("name")});
  } else if (type == "SummaryOffset") {
    Append(out, SummaryOffset{static_cast<Opcode>(record.Number("group_opcode")), record.Number("group_start"),
                              record.Number("group_length")});
  } else if (type == "DataEnd") {
    Append(out, DataEnd{Number32(record, "data_section_crc")});
  } else if (type == "Footer") {
    Append(out, Footer{record.Number("summary_start"), record.Number("summary_offset_start"),
                       Number32(record, "summary_crc")});
  } else {
    ADD_FAILURE() << "unknown type " << type;
  }
  return out;
}

// What the reader made of a record, as bytes.
template <class Record>
Buffer Again(Bytes content) {
  Buffer out;
  if constexpr (std::is_same_v<Record, Attachment>) {
    Append(out, Parse<Attachment>(content), true);
  } else {
    Append(out, Parse<Record>(content));
  }
  return out;
}

Buffer Again(const RecordView& record) {
  switch (record.opcode) {
    case Opcode::kHeader: return Again<Header>(record.content);
    case Opcode::kFooter: return Again<Footer>(record.content);
    case Opcode::kSchema: return Again<Schema>(record.content);
    case Opcode::kChannel: return Again<Channel>(record.content);
    case Opcode::kMessage: return Again<Message>(record.content);
    case Opcode::kChunkIndex: return Again<ChunkIndex>(record.content);
    case Opcode::kAttachment: return Again<Attachment>(record.content);
    case Opcode::kAttachmentIndex: return Again<AttachmentIndex>(record.content);
    case Opcode::kStatistics: return Again<Statistics>(record.content);
    case Opcode::kMetadata: return Again<Metadata>(record.content);
    case Opcode::kMetadataIndex: return Again<MetadataIndex>(record.content);
    case Opcode::kSummaryOffset: return Again<SummaryOffset>(record.content);
    case Opcode::kDataEnd: return Again<DataEnd>(record.content);
    default: return {};  // Chunks and message indexes are not listed.
  }
}

// Writes the records of the case before its end with the options that it names.
void WriteCase(const std::filesystem::path& path, const Json& document) {
  std::set<std::string> features;
  for (const Json& feature : document["meta"]["variant"]["features"].GetArray()) features.insert(feature.GetString());
  std::optional<Writer> writer;
  for (const Json& json : document["records"].GetArray()) {
    const std::string type = json["type"].GetString();
    const Expected record(json);
    if (type == "Header") {
      WriterOptions options;
      options.profile = record.Text("profile");
      options.library = record.Text("library");
      options.chunks = features.contains("ch");
      options.message_index = features.contains("mx");
      options.chunk_index = features.contains("chx");
      options.attachment_index = features.contains("ax");
      options.metadata_index = features.contains("mdx");
      options.statistics = features.contains("st");
      options.repeat_schemas = features.contains("rsh");
      options.repeat_channels = features.contains("rch");
      options.summary_offsets = features.contains("sum");
      writer.emplace(path, options);
    } else if (type == "Schema") {
      EXPECT_EQ(writer->AddSchema(record.Text("name"), record.Text("encoding"), record.Data()), record.Number("id"));
    } else if (type == "Channel") {
      EXPECT_EQ(writer->AddChannel(record.Text("topic"), record.Text("message_encoding"), Id(record, "schema_id"),
                                   record.Texts("metadata")),
                record.Number("id"));
    } else if (type == "Message") {
      const std::string data = record.Data();
      writer->Write(Message{Id(record, "channel_id"), Number32(record, "sequence"), record.Number("log_time"),
                            record.Number("publish_time"), AsBytes(data)});
    } else if (type == "Attachment") {
      writer->Write(Attachment{record.Number("log_time"), record.Number("create_time"), record.Text("name"),
                               record.Text("media_type"), record.Data()});
    } else if (type == "Metadata") {
      writer->Write(Metadata{record.Text("name"), record.Texts("metadata")});
    } else if (type == "DataEnd") {
      break;  // What follows is the writer's.
    }
  }
}

// Calls `check` with the folder's path of each case, and its description.
template <class Check>
void ForEachCase(const Check& check) {
  const char* const data = std::getenv("HGROS_DATA");
  if (data == nullptr) GTEST_SKIP() << "HGROS_DATA names no folder with recorded data.";
  int cases = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(data) / "mcap/conformance")) {
    if (entry.path().extension() != ".json") continue;
    SCOPED_TRACE(entry.path().filename().string());
    rapidjson::Document document;
    document.Parse(Contents(entry.path()).c_str());
    ASSERT_FALSE(document.HasParseError());
    check(std::filesystem::path(entry.path()).replace_extension(".mcap"), document);
    ++cases;
  }
  EXPECT_GE(cases, 94);
}

TEST(McapConformance, EveryCaseIsReadToTheSameRecords) {
  ForEachCase([](const std::filesystem::path& path, const Json& document) {
    std::vector<Buffer> expected;
    for (const Json& record : document["records"].GetArray()) {
      expected.push_back(BytesOf(record["type"].GetString(), Expected(record)));
    }
    std::vector<Buffer> read;
    Records records(path);
    for (RecordView record; records.Next(record);) {
      if (Buffer bytes = Again(record); !bytes.empty()) read.push_back(std::move(bytes));
    }
    EXPECT_TRUE(read == expected);
    EXPECT_TRUE(records.faults().empty());
    Reader reader(path);
    EXPECT_EQ(reader.fault_count(), 0U);
    Messages messages = reader.Select();
    std::size_t count = 0;
    for (Message message; messages.Next(message); ++count) EXPECT_EQ(message.log_time, 2U);
    EXPECT_EQ(count, reader.statistics().message_count);
  });
}

TEST(McapConformance, EveryCaseIsWrittenToTheSameBytes) {
  ForEachCase([](const std::filesystem::path& path, const Json& document) {
    const test::ScratchFolder folder;
    WriteCase(folder / "a.mcap", document);
    EXPECT_TRUE(folder.Read("a.mcap") == Contents(path));
  });
}

TEST(McapConformance, RecordingsOfOthersHaveTheirMessages) {
  const char* const data = std::getenv("HGROS_DATA");
  if (data == nullptr) GTEST_SKIP() << "HGROS_DATA names no folder with recorded data.";
  const std::map<std::string, std::uint64_t> counts{
      {"nav2_turtlebot", 8197}, {"rosbag2_talker", 20}, {"rosbag2_topics_and_services", 13}, {"rosbag2_cdr_test", 7}};
  for (const auto& [name, expected] : counts) {
    SCOPED_TRACE(name);
    Reader reader(std::filesystem::path(data) / "mcap" / (name + ".mcap"));
    Messages messages = reader.Select();
    std::uint64_t count = 0;
    std::uint64_t last = 0;
    for (Message message; messages.Next(message); ++count) {
      EXPECT_GE(message.log_time, last);
      last = message.log_time;
    }
    EXPECT_EQ(count, expected);
    EXPECT_EQ(reader.statistics().message_count, expected);
    EXPECT_EQ(reader.fault_count(), 0U);
  }
}

}  // namespace
}  // namespace hgros::mcap::conformance_test
