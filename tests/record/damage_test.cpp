#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/record/mcap_reader.hpp"
#include "hgros/record/mcap_writer.hpp"
#include "support/scratch_folder.hpp"
#include "support/seed.hpp"

namespace hgros::mcap::damage_test {
namespace {

using testing::HasSubstr;

constexpr std::uint32_t kChunks = 6;
constexpr std::uint32_t kMessages = 8;  // In each chunk; they are numbered.

// A chunk with the channel's description, then chunks with messages.
class Damage : public testing::TestWithParam<Compression> {
 protected:
  Damage() {
    WriterOptions options;
    options.compression = GetParam();
    Writer writer(path_, options);
    writer.AddChannel("a", "", writer.AddSchema("A", "protobuf", "descriptor"));
    writer.AddChannel("b", "", 0);
    writer.Flush();
    for (std::uint32_t i = 0; i < kChunks * kMessages; ++i) {
      const std::string data = "message " + std::to_string(i) + std::string(i % 50, 'x');
      writer.Write(Message{static_cast<std::uint16_t>(1 + i % 2), i, 1000 + i, 0, AsBytes(data)});
      if ((i + 1) % kMessages == 0) {
        writer.Flush();
        ends_.push_back(writer.size_bytes());
      }
    }
    writer.Close();
    bytes_ = folder_.Read("a.mcap");
  }

  // The numbers of all messages that can be read.
  std::vector<std::uint32_t> Read(std::uint64_t& faults) {
    std::vector<std::uint32_t> numbers;
    Reader reader(path_);
    Messages messages = reader.Select();
    for (Message message; messages.Next(message);) {
      const std::string text = "message " + std::to_string(message.sequence) + std::string(message.sequence % 50, 'x');
      EXPECT_EQ(AsText(message.data), text);
      numbers.push_back(message.sequence);
    }
    Selection of_one;
    of_one.channels = {{2}};
    std::size_t of_second = 0;
    Messages second = reader.Select(of_one);
    for (Message message; second.Next(message); ++of_second) EXPECT_EQ(message.sequence % 2, 1U);
    EXPECT_EQ(of_second, std::ranges::count_if(numbers, [](std::uint32_t number) { return number % 2 == 1; }));
    faults = reader.fault_count();
    return numbers;
  }

  // Those of the first chunks.
  static std::vector<std::uint32_t> First(std::size_t chunks) {
    std::vector<std::uint32_t> numbers(chunks * kMessages);
    for (std::uint32_t i = 0; i < numbers.size(); ++i) numbers[i] = i;
    return numbers;
  }

  // The file ends at each place, from the last to the first; a message index may be cut, too.
  void ExpectWholeChunks(std::vector<std::uint64_t> places) {
    std::ranges::sort(places, std::greater<>());
    Reader whole(path_);
    std::vector<std::uint64_t> chunk_ends;
    for (const ChunkIndex& chunk : whole.chunks()) chunk_ends.push_back(chunk.chunk_start_offset + chunk.chunk_length);
    for (const std::uint64_t place : places) {
      SCOPED_TRACE(place);
      std::filesystem::resize_file(path_, place);
      const auto chunks = std::ranges::count_if(chunk_ends, [&](std::uint64_t end) { return end <= place; });
      std::uint64_t faults = 0;
      ASSERT_EQ(Read(faults), First(std::max<std::size_t>(static_cast<std::size_t>(chunks), 1) - 1));
      ASSERT_NE(faults, 0U);
    }
  }

  // Each bit of some bytes is wrong in turn. What is in other chunks is read.
  void ExpectOtherChunks(std::size_t begin, std::size_t end, std::mt19937_64& random) {
    for (int round = 0; round < test::Rounds(300, 30'000); ++round) {
      const std::size_t place = begin + random() % (end - begin);
      std::string damaged = bytes_.substr(0, end);
      damaged[place] = static_cast<char>(damaged[place] ^ (1 << random() % 8));
      SCOPED_TRACE(place);
      folder_.Write("a.mcap", damaged);
      std::uint64_t faults = 0;
      const std::vector<std::uint32_t> numbers = Read(faults);
      std::uint64_t start = begin;
      for (std::uint32_t chunk = 0; chunk < kChunks; start = ends_[chunk++]) {
        if (place >= start && place < ends_[chunk]) continue;
        for (std::uint32_t i = 0; i < kMessages; ++i) {
          ASSERT_EQ(std::ranges::count(numbers, chunk * kMessages + i), 1) << "chunk " << chunk;
        }
      }
      if (numbers.size() != kChunks * kMessages) ASSERT_NE(faults, 0U);
    }
  }

  [[nodiscard]] std::size_t FirstChunk() const {
    const Reader reader(path_);
    return reader.chunks()[1].chunk_start_offset;
  }

  test::ScratchFolder folder_;
  std::filesystem::path path_ = folder_ / "a.mcap";
  std::string bytes_;
  std::vector<std::uint64_t> ends_;
};

INSTANTIATE_TEST_SUITE_P(Of, Damage, testing::Values(Compression::kNone, Compression::kLz4, Compression::kZstd));

TEST_P(Damage, CutAnywhereInTheLastChunkAndTheSummaryLeavesAllOtherChunks) {
  std::vector<std::uint64_t> places;
  for (std::uint64_t place = ends_[kChunks - 2]; place < bytes_.size(); ++place) places.push_back(place);
  ExpectWholeChunks(places);
}

TEST_P(Damage, CutAtAnyPlaceLeavesAllChunksBefore) {
  std::mt19937_64 random(test::Seed());
  constexpr std::uint64_t kMagicBytes = 8;
  std::vector<std::uint64_t> places(GetParam() == Compression::kNone ? 10'000 : 1'000);
  for (std::uint64_t& place : places) place = kMagicBytes + random() % (bytes_.size() - kMagicBytes);
  ExpectWholeChunks(places);
}

TEST_P(Damage, OfOneBitLosesAtMostItsChunk) {
  std::mt19937_64 random(test::Seed());
  ExpectOtherChunks(FirstChunk(), bytes_.size(), random);
}

TEST_P(Damage, OfOneBitInAFileWithoutSummaryLosesAtMostItsChunk) {
  std::mt19937_64 random(test::Seed());
  ExpectOtherChunks(FirstChunk(), ends_.back(), random);
}

TEST_P(Damage, OfAChunkIsReportedWithItsMessages) {
  std::string damaged = bytes_;
  damaged[ends_[1] + 80] ^= 1;
  for (const std::string& bytes : {damaged, damaged.substr(0, ends_.back())}) {
    folder_.Write("a.mcap", bytes);
    Reader reader(path_);
    Messages messages = reader.Select();
    for (Message message; messages.Next(message);) {
    }
    ASSERT_FALSE(reader.faults().empty());
    EXPECT_THAT(reader.faults().front().what,
                HasSubstr("The chunk at byte " + std::to_string(ends_[1]) + " cannot be read: "));
    EXPECT_EQ(reader.faults().front().messages, kMessages);
  }
}

}  // namespace
}  // namespace hgros::mcap::damage_test
