// A program that writes a recording and reads it.
#include <filesystem>

#include <hgros/record/mcap_reader.hpp>
#include <hgros/record/mcap_writer.hpp>

int main(int, char** arguments) {
  std::filesystem::remove(arguments[1]);
  hgros::mcap::Writer writer(arguments[1]);
  writer.AddChannel("scan", "protobuf", writer.AddSchema("foxglove.LaserScan", "protobuf", ""));
  writer.Write(hgros::mcap::Message{1, 1, 1'000, 1'000, hgros::AsBytes("scan")});
  writer.Close();
  hgros::mcap::Reader reader(arguments[1]);
  hgros::mcap::Messages messages = reader.Select();
  hgros::mcap::Message message;
  return messages.Next(message) && hgros::AsText(message.data) == "scan" && !messages.Next(message) ? 0 : 1;
}
