#include "viewer/data/channels/type_conflict.hpp"

#include <gtest/gtest.h>

namespace hgros::viewer {
namespace {

ChannelUser User(const std::string& process, const std::string& type, std::uint64_t fingerprint) {
  ChannelUser user;
  user.process = process;
  user.type_name = type;
  user.fingerprint = fingerprint;
  return user;
}

TEST(TypeConflict, IsEmptyIfAllUseOneType) {
  KnownChannel channel{"scan", "Scan", {}, 7, {User("robot", "Scan", 7)}, {User("viewer", "Scan", 7)}};
  EXPECT_EQ(TypeConflict(channel), "");
  channel.subscribers.push_back(User("recorder", "", 0));
  EXPECT_EQ(TypeConflict(channel), "") << "it accepts any type";
  channel.subscribers.push_back(User("echo", "Scan", 0));
  EXPECT_EQ(TypeConflict(channel), "") << "its version is unknown";
  EXPECT_EQ(TypeConflict({}), "");
}

TEST(TypeConflict, NamesTypesAndTheirUsers) {
  const KnownChannel channel{
      "scan", "Scan", {}, 7, {User("robot", "Scan", 7)}, {User("viewer", "Grid", 9), User("other", "Scan", 7)}};
  EXPECT_EQ(TypeConflict(channel),
            "Its users do not agree on the type: Grid is subscribed to by viewer; Scan is published by robot, and "
            "subscribed to by other. No messages pass between different types.");
}

TEST(TypeConflict, DistinguishesSchemasWithTheSameName) {
  const KnownChannel channel{"scan", "Scan", {}, 7, {User("robot", "Scan", 7)}, {User("viewer", "Scan", 9)}};
  EXPECT_EQ(TypeConflict(channel),
            "Its users do not agree on the type: Scan (schema 0000000000000007) is published by robot; Scan "
            "(schema 0000000000000009) is subscribed to by viewer. Messages pass only between compatible schemas.");
}

TEST(TypeConflict, NamesOnlySomeOfManyUsers) {
  KnownChannel channel{"scan", "Scan", {}, 7, {User("robot", "Grid", 7)}, {}};
  for (int i = 0; i < 9; ++i) channel.subscribers.push_back(User("viewer " + std::to_string(i), "Scan", 9));
  EXPECT_NE(TypeConflict(channel).find("viewer 0, viewer 1, viewer 2, viewer 3 and 5 more"), std::string::npos);
}

}  // namespace
}  // namespace hgros::viewer
