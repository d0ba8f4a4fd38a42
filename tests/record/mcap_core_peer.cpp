// mcap_core_peer write|read FOLDER
// Writes files with all options, or reads files, and prints what is in them: the other side of mcap_core.mjs.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/record/mcap_reader.hpp"
#include "hgros/record/mcap_writer.hpp"

namespace {

using hgros::mcap::Message;
using hgros::mcap::WriterOptions;

constexpr int kFlags = 9;

void Write(const std::filesystem::path& folder) {
  for (int options = 0; options < 3 << kFlags; ++options) {
    WriterOptions chosen;
    bool* const flags[kFlags] = {&chosen.chunks,           &chosen.message_index,   &chosen.chunk_index,
                                 &chosen.attachment_index, &chosen.metadata_index,  &chosen.statistics,
                                 &chosen.repeat_schemas,   &chosen.repeat_channels, &chosen.summary_offsets};
    for (int i = 0; i < kFlags; ++i) *flags[i] = (options >> i & 1) != 0;
    chosen.compression = static_cast<hgros::mcap::Compression>(options >> kFlags);
    chosen.chunk_bytes = 500;
    hgros::mcap::Writer writer(folder / (std::to_string(options) + ".mcap"), chosen);
    const auto schema = writer.AddSchema("Example", "jsonschema", "{}");
    writer.AddChannel("with schema", "json", schema, {{"key", "value"}});
    writer.AddChannel("without", "text", 0);
    for (std::uint32_t i = 0; i < 20; ++i) {
      const std::string data = std::to_string(options) + std::string(i * 7, 'x');
      writer.Write(Message{static_cast<std::uint16_t>(1 + i % 2), i, 100 + i * 37 % 20, i, hgros::AsBytes(data)});
    }
    writer.Write(hgros::mcap::Attachment{7, 8, "name", "text/plain", "attached"});
    writer.Write(hgros::mcap::Metadata{"about", {{"robot", "r2"}}});
  }
}

void Read(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    hgros::mcap::Reader reader(file);
    std::cout << file.filename().string() << '\n';
    hgros::mcap::Messages messages = reader.Select();
    for (Message message; messages.Next(message);) {
      const auto& channel = reader.channels().at(message.channel_id);
      std::cout << channel.topic << ' ' << channel.message_encoding << ' ' << channel.metadata.size() << ' '
                << (channel.schema_id == 0 ? "-" : reader.schemas().at(channel.schema_id).name) << ' '
                << message.sequence << ' ' << message.log_time << ' ' << message.publish_time << ' '
                << hgros::AsText(message.data) << '\n';
    }
    for (const auto& index : reader.attachments()) {
      const hgros::mcap::Attachment attachment = reader.Read(index);
      std::cout << attachment.name << ' ' << attachment.media_type << ' ' << attachment.log_time << ' '
                << attachment.create_time << ' ' << attachment.data << '\n';
    }
    for (const auto& index : reader.metadata()) {
      const hgros::mcap::Metadata metadata = reader.Read(index);
      for (const auto& [key, value] : metadata.metadata)
        std::cout << metadata.name << ' ' << key << ' ' << value << '\n';
    }
    for (const auto& fault : reader.faults()) std::cout << fault.what << '\n';
  }
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) return 2;
  try {
    (std::string_view(arguments[1]) == "write" ? Write : Read)(arguments[2]);
  } catch (const hgros::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
