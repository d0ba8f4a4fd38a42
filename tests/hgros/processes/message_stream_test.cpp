#include "processes/message_stream.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "launch/run.pb.h"

namespace hgros::cli {
namespace {

RunReport LineOf(std::string text) {
  RunReport report;
  report.mutable_line()->set_text(std::move(text));
  return report;
}

class MessageStreamTest : public testing::Test {
 protected:
  MessageStreamTest() { Connect(); }
  void Connect() {
    std::array<int, 2> sockets{};
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, sockets.data()), 0);
    writer_ = std::make_unique<MessageStream>(sockets[0]);
    reader_ = std::make_unique<MessageStream>(sockets[1]);
  }

  std::unique_ptr<MessageStream> writer_;
  std::unique_ptr<MessageStream> reader_;
};

TEST_F(MessageStreamTest, KeepsOrderWhateverTheSizes) {
  std::mt19937 random(7);
  std::vector<std::string> sent;
  std::vector<std::string> got;
  for (int i = 0; i < 200; ++i) {
    sent.emplace_back(random() % (i % 50 == 0 ? 700'000 : 300), static_cast<char>('a' + i % 26));
    writer_->Add(LineOf(sent.back()));
  }
  while (got.size() < sent.size()) {
    ASSERT_TRUE(writer_->Write());
    ASSERT_TRUE(reader_->Read());
    RunReport report;
    while (reader_->Next(report)) got.push_back(report.line().text());
  }
  EXPECT_EQ(got, sent);
  EXPECT_EQ(writer_->unsent(), 0U);
}

TEST_F(MessageStreamTest, KeepsWhatDoesNotFit) {
  writer_->Add(LineOf(std::string(4 << 20, 'x')));
  EXPECT_TRUE(writer_->Write());
  EXPECT_GT(writer_->unsent(), 0U);
}

TEST_F(MessageStreamTest, EndsWithItsOtherSide) {
  writer_->Add(LineOf("last"));
  ASSERT_TRUE(writer_->Write());
  writer_.reset();
  RunReport report;
  while (reader_->Read()) {
  }
  ASSERT_TRUE(reader_->Next(report));
  EXPECT_EQ(report.line().text(), "last");
  EXPECT_FALSE(reader_->Next(report));
}

TEST_F(MessageStreamTest, CarriesAnyBytes) {
  writer_->Add(LineOf(std::string("\xfe\xff\0x", 4)));
  ASSERT_TRUE(writer_->Write());
  ASSERT_TRUE(reader_->Read());
  RunReport report;
  ASSERT_TRUE(reader_->Next(report));
  EXPECT_EQ(report.line().text(), std::string("\xfe\xff\0x", 4));
}

TEST_F(MessageStreamTest, EndsAtWhatIsNoMessageButWaitsForTheRestOfOne) {
  for (const auto& [bytes, waits] :
       {std::pair(std::string("\x02\0\0\0\xff\xff", 6), false), std::pair(std::string("\xff\xff\xff\xff"), false),
        std::pair(std::string("\x04\0\0\0\x08", 5), true)}) {
    Connect();
    ASSERT_EQ(write(writer_->descriptor(), bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
    RunReport report;
    EXPECT_TRUE(reader_->Read());
    EXPECT_FALSE(reader_->Next(report));
    EXPECT_EQ(reader_->Read(), waits);
  }
}

}  // namespace
}  // namespace hgros::cli
