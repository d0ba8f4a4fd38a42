#include "terminal/json.hpp"

#include <gtest/gtest.h>

namespace hgros::cli {
namespace {

TEST(Json, EscapesWhatATerminalWouldObey) {
  Json json;
  json.BeginObject().Member("a\x1b", "\x7F\xC2\x9B\xE2\x80\xAE\xFF \xC3\xA9").EndObject();
  EXPECT_EQ(json.text(), "{\"a\\u001B\":\"\\u007F\\u009B\\u202E\\uFFFD \\u00E9\"}");
}

}  // namespace
}  // namespace hgros::cli
