#include "discovery/registry/announcement_file.hpp"

#include <gtest/gtest.h>

#include "discovery/listening.hpp"
#include "hgros/announcement.pb.h"
#include "hgros/discovery/announcement.hpp"

namespace hgros::discovery {
namespace {

wire::AnnouncementFile Message(const std::string& bytes) {
  wire::AnnouncementFile message;
  EXPECT_TRUE(message.ParseFromString(bytes));
  return message;
}

TEST(AnnouncementFile, ReadsBackWhatWasWritten) {
  const Announcement own = NewAnnouncement();
  const ParsedFile parsed = ParseFile(AsBytes(EncodeFile(own)));
  ASSERT_TRUE(parsed.announcement) << parsed.fault;
  EXPECT_EQ(*parsed.announcement, own);
}

TEST(AnnouncementFile, NamesTheTransportsOfAChannelForOlderSessions) {
  using Keys = std::vector<std::string>;
  struct Case {
    TransportKeys transports;
    bool not_by_shared_memory, not_by_endpoints;
    bool reads_back;  // True if the rule is read back from the fields of an older session.
  };
  for (const Case& one : {Case{std::nullopt, false, false, true}, Case{Keys{"zmq"}, true, false, true},
                          Case{Keys{"shared_memory"}, false, true, true}, Case{Keys{"loop"}, true, true, false}}) {
    Announcement own = NewAnnouncement();
    own.channels.resize(1);
    own.channels[0].transports = one.transports;
    wire::AnnouncementFile file = Message(EncodeFile(own));
    wire::AnnouncedChannel& channel = *file.mutable_channels(0);
    EXPECT_EQ(channel.not_by_shared_memory(), one.not_by_shared_memory);
    EXPECT_EQ(channel.not_by_endpoints(), one.not_by_endpoints);
    channel.clear_transports();
    const ParsedFile parsed = ParseFile(AsBytes(file.SerializeAsString()));
    ASSERT_TRUE(parsed.announcement) << parsed.fault;
    EXPECT_EQ(parsed.announcement->channels[0].transports, one.reads_back ? one.transports : Keys());
  }
}

TEST(AnnouncementFile, SkipsUnknownFields) {
  const Announcement own = NewAnnouncement();
  const std::string unknown_field("\xfa\x7f\x03new", 6);
  EXPECT_EQ(ParseFile(AsBytes(EncodeFile(own) + unknown_field)).announcement, own);
}

TEST(AnnouncementFile, EscapesControlCharacters) {
  Announcement own = NewAnnouncement("\x1b[2Jname\n");
  own.host = std::string(1000, 'h');
  const ParsedFile parsed = ParseFile(AsBytes(EncodeFile(own)));
  ASSERT_TRUE(parsed.announcement);
  EXPECT_EQ(parsed.announcement->process, R"(\x1b[2Jname\n)");
  EXPECT_EQ(parsed.announcement->host, std::string(kMaxAnnouncedTextBytes, 'h'));
}

TEST(AnnouncementFile, ReportsWhyAFileIsRefused) {
  struct Case {
    std::string words;
    std::function<void(wire::AnnouncementFile&)> spoil;
  };
  const std::vector<Case> cases{
      {"version " + std::to_string(kFileVersion + 1), [](auto& file) { file.set_version(kFileVersion + 1); }},
      {"no session", [](auto& file) { file.set_session(0); }},
      {"endpoints", [](auto& file) { file.add_endpoints(""); }},
      {"endpoints", [](auto& file) { file.add_endpoints("tcp://\n"); }},
      {"endpoints", [](auto& file) { file.add_endpoints(std::string(kMaxAnnouncedTextBytes + 1, 'x')); }},
      {"more than 16 endpoints",
       [](auto& file) {
         for (int i = 0; i < 17; ++i) file.add_endpoints("tcp://a:1");
       }},
      {"boot id", [](auto& file) { file.set_boot_id("\n"); }},
      {"places of transports", [](auto& file) { file.add_places()->set_place("x"); }},
      {"a transport of channel", [](auto& file) { file.mutable_channels(0)->add_transports("a\n"); }},
      {"shared memory", [](auto& file) { file.set_shared_memory(std::string(kMaxPathBytes + 1, 'x')); }},
      {"channel names", [](auto& file) { file.add_channels()->set_channel("a b"); }},
      {"channel names", [](auto& file) { file.add_channels(); }},
      {"type name", [](auto& file) { file.mutable_channels(0)->set_type_name("\x7f"); }},
      {"type name", [](auto& file) { file.mutable_channels(0)->set_type_name(std::string(1025, 'x')); }},
      {"encoding", [](auto& file) { file.mutable_channels(0)->set_encoding(99); }},
  };
  for (const Case& one : cases) {
    wire::AnnouncementFile file = Message(EncodeFile(NewAnnouncement()));
    one.spoil(file);
    const ParsedFile parsed = ParseFile(AsBytes(file.SerializeAsString()));
    EXPECT_FALSE(parsed.announcement) << one.words;
    EXPECT_NE(parsed.fault.find(one.words), std::string::npos) << parsed.fault;
  }
}

TEST(AnnouncementFile, HasTheLongestTypeNameThatAChannelMayHave) {
  wire::AnnouncementFile file = Message(EncodeFile(NewAnnouncement()));
  file.mutable_channels(0)->set_type_name(std::string(kMaxTypeNameBytes, 'x'));
  const ParsedFile parsed = ParseFile(AsBytes(file.SerializeAsString()));
  ASSERT_TRUE(parsed.announcement) << parsed.fault;
  EXPECT_EQ(parsed.announcement->channels.at(0).type_name.size(), kMaxTypeNameBytes);
}

TEST(AnnouncementFile, TruncatedFileIsReadWhereValidOrRefused) {
  const std::string bytes = EncodeFile(NewAnnouncement());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const ParsedFile parsed = ParseFile(AsBytes(std::string_view(bytes).substr(0, size)));
    EXPECT_NE(parsed.announcement.has_value(), !parsed.fault.empty());
  }
}

}  // namespace
}  // namespace hgros::discovery
