// Any file is read without a crash, with faults where it is damaged, and twice to the same messages.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/record/mcap_reader.hpp"
#include "support/scratch_folder.hpp"

namespace {

using Read = std::vector<std::pair<std::uint64_t, std::string>>;

Read ReadAll(hgros::mcap::Reader& reader, hgros::mcap::Order order) {
  Read result;
  hgros::mcap::Messages messages = reader.Select({.channels = {}, .order = order});
  for (hgros::mcap::Message message; messages.Next(message);) {
    if (!reader.channels().contains(message.channel_id)) std::abort();
    result.emplace_back(message.log_time, hgros::AsText(message.data));
  }
  return result;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const hgros::test::ScratchFolder* const folder = new hgros::test::ScratchFolder;
  const auto path = folder->Write("a.mcap", {reinterpret_cast<const char*>(data), size});
  try {
    hgros::mcap::Reader reader(path);
    const Read by_time = ReadAll(reader, hgros::mcap::Order::kLogTime);
    if (by_time.size() != ReadAll(reader, hgros::mcap::Order::kFile).size()) std::abort();
    for (const auto& index : reader.metadata()) (void)reader.Read(index);
    for (const auto& index : reader.attachments()) (void)reader.Read(index);
    hgros::mcap::Records records(path);
    for (hgros::mcap::RecordView record; records.Next(record);) {
    }
  } catch (const hgros::Error&) {  // Not an MCAP file, or a damaged attachment.
  }
  return 0;
}
