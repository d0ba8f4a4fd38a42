// Any file is read without a crash, in each order to as many messages, and channel by channel to as many.
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

Read ReadAll(hgros::mcap::Reader& reader, const hgros::mcap::Selection& selection) {
  Read result;
  hgros::mcap::Messages messages = reader.Select(selection);
  for (hgros::mcap::Message message; messages.Next(message);) {
    if (!reader.channels().contains(message.channel_id)) std::abort();
    result.emplace_back(message.log_time, hgros::AsText(message.data));
  }
  return result;
}

// A damaged record is an Error.
template <class Action>
void Try(const Action& action) {
  try {
    action();
  } catch (const hgros::Error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const hgros::test::ScratchFolder* const folder = new hgros::test::ScratchFolder;
  const auto path = folder->Write("a.mcap", {reinterpret_cast<const char*>(data), size});
  try {
    hgros::mcap::Reader reader(path);
    hgros::mcap::Selection selection;
    const std::size_t count = ReadAll(reader, selection).size();
    selection.order = hgros::mcap::Order::kFile;
    if (ReadAll(reader, selection).size() != count) std::abort();
    std::size_t of_channels = 0;
    for (const auto& [id, channel] : reader.channels()) {
      selection.channels = {{id}};
      of_channels += ReadAll(reader, selection).size();
    }
    if (!reader.has_summary() && of_channels != count) std::abort();
    for (const auto& index : reader.metadata()) Try([&] { (void)reader.Read(index); });
    for (const auto& index : reader.attachments()) Try([&] { (void)reader.Read(index); });
    hgros::mcap::Records records(path);
    for (hgros::mcap::RecordView record; records.Next(record);) {
    }
  } catch (const hgros::Error&) {  // Not an MCAP file.
  }
  return 0;
}
