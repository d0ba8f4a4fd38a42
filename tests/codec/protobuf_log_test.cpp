#include "hgros/codec/protobuf_log.hpp"

#include <google/protobuf/stubs/logging.h>
#include <gtest/gtest.h>

#include <foxglove/Log.pb.h>

namespace hgros {
namespace {

int said = 0;
void Count(google::protobuf::LogLevel, const char*, int, const std::string&) { ++said; }

TEST(ProtobufLog, DoesNotRepeatThatTextsAreNotUtf8) {
  google::protobuf::LogHandler* const before = google::protobuf::SetLogHandler(Count);
  LimitProtobufLog();
  LimitProtobufLog();
  for (int i = 0; i < 100; ++i) {
    foxglove::Log log;
    EXPECT_FALSE(log.ParseFromString("\x1a\x01\xff"));  // Field 3, a text of one byte.
  }
  EXPECT_EQ(said, 1);
  google::protobuf::SetLogHandler(before);
}

}  // namespace
}  // namespace hgros
