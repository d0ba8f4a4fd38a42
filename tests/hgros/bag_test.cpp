#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"
#include "hgros/record/mcap_reader.hpp"
#include "hgros/record/mcap_writer.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// A recording with ten chunks, each with a message of "scan" and one of "status".
class HgrosBag : public testing::Test {
 protected:
  static constexpr std::uint64_t kChunks = 10;

  HgrosBag() {
    mcap::WriterOptions options;
    options.compression = mcap::Compression::kZstd;
    mcap::Writer writer(path_, options);
    const auto scan = writer.AddChannel("scan", "protobuf", writer.AddSchema("foxglove.LaserScan", "protobuf", "S"));
    const auto status = writer.AddChannel("status\x1b[31m", "json", 0);
    for (std::uint64_t i = 0; i < kChunks; ++i) {
      const std::uint64_t time = 1'700'000'000'000'000'000 + i * 250'000'000;
      writer.Write(mcap::Message{scan, 0, time, time, AsBytes(std::string(1000, 'x'))});
      writer.Write(mcap::Message{status, 0, time + 1, time, AsBytes("{}")});
      writer.Flush();
    }
    writer.Write(mcap::Attachment{0, 0, "robot.yaml", "text/yaml", "a: 1"});
    writer.Write(mcap::Metadata{"about", {{"robot", "r2"}}});
    writer.Close();
  }

  // As if its writer had been killed within the last chunk.
  void CutWithinTheLastChunk() const {
    std::uint64_t place = 0;
    {
      const mcap::Reader reader(path_);
      place = reader.chunks().back().chunk_start_offset + 20;
    }
    std::filesystem::resize_file(path_, place);
  }
  void DamageTheThirdChunk() {
    std::string bytes = folder_.Read("run.mcap");
    const mcap::Reader reader(path_);
    bytes[reader.chunks()[2].chunk_start_offset + reader.chunks()[2].chunk_length - 5] ^= 1;
    folder_.Write("run.mcap", bytes);
  }

  const test::ScratchFolder folder_;
  const std::string path_ = (folder_ / "run.mcap").string();
};

TEST_F(HgrosBag, ShowsWhatIsInARecording) {
  EXPECT_THAT(RunToEnd({"bag", "info", path_}),
              Writes(AllOf(HasSubstr("Duration    2.25 s\n"), HasSubstr("Messages    20\n"),
                           HasSubstr("Chunks      10 (zstd, "), HasSubstr("Written by  hgros\n"),
                           testing::ContainsRegex("scan +foxglove.LaserScan +protobuf +10 +4.44 Hz\n"),
                           testing::ContainsRegex("robot.yaml +text/yaml +4 B\n"), HasSubstr("about\n"),
                           testing::Not(HasSubstr("\x1b")))));
  const CommandEnd json = RunToEnd({"bag", "info", path_, "--json"});
  EXPECT_THAT(LinesOf(json.out),
              ElementsAre(AllOf(HasSubstr("\"duration_ns\":2250000001,"), HasSubstr("\"messages\":20,"),
                                HasSubstr("{\"channel\":\"scan\",\"type\":\"foxglove.LaserScan\","))));
  EXPECT_THAT(RunToEnd({"bag", "info", path_ + "x"}), Ends(1, HasSubstr("run.mcapx")));
  const std::string other = folder_.Write("other.mcap", "no recording");
  EXPECT_THAT(RunToEnd({"bag", "info", other}), Ends(1, HasSubstr("other.mcap")));
}

TEST_F(HgrosBag, IsSilentAboutAWholeRecordingAndListsWhatIsDamaged) {
  EXPECT_THAT(RunToEnd({"bag", "check", path_}), Writes(""));
  DamageTheThirdChunk();
  EXPECT_THAT(RunToEnd({"bag", "check", path_}), Prints(1, HasSubstr("Messages lost: 2.\n")));
  CutWithinTheLastChunk();
  EXPECT_THAT(LinesOf(RunToEnd({"bag", "check", path_, "--json"}).out),
              ElementsAre(HasSubstr("\"messages\":2}"), HasSubstr("\"what\":\"The chunk at byte ")));
}

TEST_F(HgrosBag, RecoversAllWholeChunks) {
  DamageTheThirdChunk();
  CutWithinTheLastChunk();
  EXPECT_THAT(RunToEnd({"bag", "info", path_}).err, HasSubstr("no usable summary"));
  const CommandEnd end = RunToEnd({"bag", "recover", path_, "--json"});
  EXPECT_THAT(end, Ends(0, AllOf(HasSubstr("hgros: The chunk at byte "), HasSubstr(" Messages lost: 2.\n"))));
  const std::string recovered = (folder_ / "run.recovered.mcap").string();
  EXPECT_EQ(end.out, "{\"file\":\"" + recovered + "\",\"messages\":16,\"faults\":2,\"messages_lost\":2}\n");
  EXPECT_THAT(RunToEnd({"bag", "check", recovered}), Writes(""));
  mcap::Reader reader(recovered);
  EXPECT_TRUE(reader.has_summary());
  EXPECT_EQ(reader.schemas().begin()->second.name, "foxglove.LaserScan");
  EXPECT_EQ(reader.chunks().front().compression, "zstd");
  EXPECT_THAT(RunToEnd({"bag", "recover", path_}), Ends(1, HasSubstr(recovered))) << "it is there";
}

TEST_F(HgrosBag, CopiesAllOfAWholeRecording) {
  const std::string copy = (folder_ / "copy.mcap").string();
  EXPECT_THAT(RunToEnd({"bag", "recover", path_, "-o", copy}), Writes(""));
  mcap::Reader before(path_);
  mcap::Reader after(copy);
  EXPECT_EQ(after.statistics().channel_message_counts, before.statistics().channel_message_counts);
  EXPECT_EQ(after.Read(after.attachments().at(0)), before.Read(before.attachments().at(0)));
  EXPECT_EQ(after.Read(after.metadata().at(0)), before.Read(before.metadata().at(0)));
  mcap::Messages old_messages = before.Select();
  mcap::Messages new_messages = after.Select();
  for (mcap::Message one, other; old_messages.Next(one);) {
    ASSERT_TRUE(new_messages.Next(other));
    EXPECT_EQ(AsText(other.data), AsText(one.data));
    EXPECT_EQ(other.log_time, one.log_time);
  }
}

TEST_F(HgrosBag, ExamplesWork) {
  for (const std::string command : {"info", "check", "recover"}) {
    for (std::vector<std::string>& example : ExamplesOf("bag " + command)) {
      for (std::string& word : example) {
        if (word.ends_with(".mcap")) word = (folder_ / word).string();
      }
      EXPECT_EQ(RunToEnd(example).status, 0) << command;
    }
  }
}

}  // namespace
}  // namespace hgros::cli
