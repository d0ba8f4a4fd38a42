#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "doctor/evidence.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

ChannelUser UserOf(std::uint64_t session, const std::string& process) {
  const auto pid = static_cast<std::int64_t>(session);
  return {.session = {session}, .process = process, .host = "robot", .pid = pid, .type_name = "T"};
}

// A talker (1) and a listener (2), and their counters one second apart.
class DoctorChecks : public testing::Test {
 protected:
  DoctorChecks() {
    evidence.names = {{SessionId{1}, "talker:1"}, {SessionId{2}, "listener:2"}};
    evidence.here = {SessionId{1}, SessionId{2}};
    for (auto* counters : {&evidence.before, &evidence.after}) {
      for (std::uint64_t session = 1; session <= 2; ++session) {
        auto snapshot = std::make_shared<Snapshot>();
        snapshot->set_host("robot");
        snapshot->set_version("1");
        snapshot->set_steady_ns(counters == &evidence.before ? 0 : 1'000'000'000);
        (*counters)[SessionId{session}] = snapshot;
      }
    }
  }
  KnownChannel& AddChannel(const std::string& name, bool published, bool subscribed) {
    KnownChannel channel;
    channel.name = name;
    if (published) channel.publishers.push_back(UserOf(1, "talker"));
    if (subscribed) channel.subscribers.push_back(UserOf(2, "listener"));
    evidence.channels_before.push_back(channel);
    std::ranges::sort(evidence.channels_before, {}, &KnownChannel::name);
    return evidence.channels.emplace_back(channel);
  }
  // Of both readings; the counters begin at zero.
  std::pair<Snapshot::Channel*, Snapshot::Channel*> Count(std::uint64_t session, const std::string& channel) {
    const auto add = [&](AllCounters& counters) {
      Snapshot::Channel* one = const_cast<Snapshot&>(*counters[SessionId{session}]).add_channels();
      one->set_name(channel);
      return one;
    };
    return {add(evidence.before), add(evidence.after)};
  }
  // Channel "scan" with node "match" of the listener, whose queue of four messages is full in both readings.
  std::pair<Snapshot::Channel*, Snapshot::Channel*> CountFullQueue() {
    AddChannel("scan", true, true);
    const auto [before, after] = Count(2, "scan");
    for (Snapshot::Channel* channel : {before, after}) {
      Snapshot::Node& node = *channel->add_nodes();
      node.set_name("match");
      node.set_serial(true);
      node.set_queue_depth(4);
      node.set_queued(4);
    }
    return {before, after};
  }
  [[nodiscard]] std::vector<std::string> Say(void (*check)(const Evidence&, Findings&),
                                             Severity from = Severity::kWarning) const {
    Findings findings;
    check(evidence, findings);
    std::vector<std::string> said;
    for (const Finding& finding : findings) {
      if (finding.severity > from) continue;
      EXPECT_NE(finding.fix, "") << finding.what;
      said.push_back(finding.what);
    }
    return said;
  }

  // The only advice of a check.
  [[nodiscard]] std::string Fix(void (*check)(const Evidence&, Findings&)) const {
    Findings findings;
    check(evidence, findings);
    EXPECT_EQ(findings.size(), 1U);
    return findings.empty() ? "" : findings.front().fix;
  }
  // How the talker exchanges messages with the listener, in both readings.
  void MeetOver(const std::string& transport, const std::string& why = {}) {
    for (AllCounters* counters : {&evidence.before, &evidence.after}) {
      Snapshot& talker = const_cast<Snapshot&>(*(*counters)[SessionId{1}]);
      talker.clear_peers();
      Snapshot::Peer& peer = *talker.add_peers();
      peer.set_session(2);
      peer.set_transport(transport);
      peer.set_why(why);
    }
  }

  Evidence evidence;
};

TEST_F(DoctorChecks, SayNothingWhenNothingIsWrong) {
  AddChannel("scan", true, true);
  AddChannel("map", true, false);
  Count(1, "scan").second->set_published(100);
  EXPECT_THAT(Say(CheckChannels), IsEmpty());
  EXPECT_THAT(Say(CheckNodes), IsEmpty());
  EXPECT_THAT(Say(CheckSessions), IsEmpty());
}

TEST_F(DoctorChecks, NameTypesThatDoNotFit) {
  AddChannel("scan", true, true).subscribers[0].type_name = "Other";
  EXPECT_THAT(Say(CheckChannels),
              ElementsAre("talker:1 publishes T on \"scan\", but listener:2 subscribes to Other: messages reach it "
                          "only if it takes bytes (FromAnyRaw)."));
  evidence.channels[0].subscribers[0].type_name = "";  // Any type.
  EXPECT_THAT(Say(CheckChannels), IsEmpty());
}

TEST_F(DoctorChecks, NameMisspelledAndMissingChannels) {
  AddChannel("scan_front", true, false);
  AddChannel("scan_frotn", false, true);
  AddChannel("goal", false, true);
  AddChannel("hgros/call/plan", false, true);  // A service that nobody calls.
  EXPECT_THAT(Say(CheckChannels), ElementsAre(AllOf(HasSubstr("listener:2 subscribes to \"scan_frotn\""),
                                                    HasSubstr("talker:1 publishes \"scan_front\"")),
                                              "Nobody publishes \"goal\", to which listener:2 subscribes."));
}

TEST_F(DoctorChecks, MissNoStaticTransformsWhereOthersArePublished) {
  AddChannel("tf", false, true);
  AddChannel("tf_static", false, true);
  EXPECT_EQ(Say(CheckChannels).size(), 2U);
  evidence.channels[0].publishers.push_back(UserOf(1, "talker"));
  EXPECT_THAT(Say(CheckChannels), IsEmpty());
  std::swap(evidence.channels[0].name, evidence.channels[1].name);  // Only static ones.
  EXPECT_THAT(Say(CheckChannels), IsEmpty());
}

TEST_F(DoctorChecks, MissNoPublisherThatOnlyTheSubscriberMeets) {
  AddChannel("velocity", false, true);
  Count(2, "velocity").second->set_publishers(1);
  EXPECT_THAT(Say(CheckChannels), IsEmpty());
}

TEST_F(DoctorChecks, NameTwoChannelsThatDifferByASlash) {
  AddChannel("/sped", true, true);
  AddChannel("sped", true, true);
  EXPECT_THAT(
      Say(CheckChannels),
      ElementsAre("\"/sped\", which talker:1 publishes, and \"sped\", which talker:1 publishes, are two channels."));
}

TEST_F(DoctorChecks, NameFramesThatNoTransformHas) {
  AddChannel("cloud", true, true);
  AddChannel("scan", true, true);
  evidence.frames = {{"cloud", "lasr"}, {"scan", "laser"}};
  EXPECT_THAT(Say(CheckChannels), IsEmpty()) << "no transforms are known";
  evidence.known_frames = {"base", "laser"};
  EXPECT_THAT(Say(CheckChannels),
              ElementsAre("\"cloud\" of talker:1 is in frame \"lasr\", which no transform had within two seconds. The "
                          "nearest frame is \"laser\"."));
  AddChannel("tf", false, true);
  Count(2, "tf").second->set_publishers(1);
  EXPECT_THAT(Say(CheckChannels), IsEmpty()) << "a session that is not met sends others";
}

TEST_F(DoctorChecks, NameSessionsThatOfferParametersUnderOneName) {
  AddChannel("params/planner/state", true, false);
  EXPECT_THAT(Say(CheckSessions), IsEmpty());
  evidence.channels[0].publishers.push_back(UserOf(2, "listener"));
  EXPECT_THAT(Say(CheckSessions), IsEmpty()) << "for a moment";
  evidence.channels_before = evidence.channels;
  EXPECT_THAT(Say(CheckSessions), ElementsAre("talker:1 and listener:2 offer parameters under one name, \"planner\". A "
                                              "change goes to all, and any of them answers."));
}

TEST_F(DoctorChecks, NameAMisspelledChannelThatOthersHear) {
  AddChannel("scan_front", true, true);
  AddChannel("scan_frotn", false, true);
  EXPECT_THAT(Say(CheckChannels),
              ElementsAre("Nobody publishes \"scan_frotn\", to which listener:2 subscribes. talker:1 "
                          "publishes \"scan_front\"."));
}

TEST_F(DoctorChecks, NameWhoLosesMessagesNow) {
  AddChannel("scan", true, true).subscribers[0].lossless = true;
  const auto [before, after] = Count(1, "scan");
  before->set_send_dropped(50);
  after->set_send_dropped(57);
  after->set_refused(3);
  const auto [earlier, later] = Count(2, "scan");
  earlier->set_lost(1);
  later->set_lost(3);
  EXPECT_THAT(Say(CheckChannels), ElementsAre(HasSubstr("talker:1 drops 7.0 messages per second of \"scan\""),
                                              HasSubstr("talker:1 cannot publish 3.0 messages per second on \"scan\""),
                                              HasSubstr("listener:2 loses 2.0 messages per second of \"scan\"")));
}

TEST_F(DoctorChecks, SayThatACallbackDoesNotReturn) {
  const auto [before, after] = CountFullQueue();
  after->mutable_nodes(0)->set_received(100);
  EXPECT_THAT(
      Say(CheckNodes),
      ElementsAre("The queue of listener:2 match on \"scan\" is always full (4 messages): its callback has never "
                  "returned and a message comes every 10.0 ms."));
  for (Snapshot::Channel* channel : {before, after}) channel->mutable_nodes(0)->set_run(5);
  EXPECT_THAT(Say(CheckNodes), ElementsAre(HasSubstr("its callback has not returned for 1.00 s and")));
}

TEST_F(DoctorChecks, NameSlowCallbacksFullQueuesAndExceptions) {
  const auto [before, after] = CountFullQueue();
  Snapshot::Node& node = *after->mutable_nodes(0);
  node.set_received(100);
  node.set_run(20);
  node.set_run_sum_ns(980'000'000);
  EXPECT_THAT(Say(CheckNodes),
              ElementsAre("listener:2 match is busy for 98 % of the time: its callback takes 49.0 ms and a message "
                          "comes every 10.0 ms."));
  node.set_dropped(80);
  node.set_handed_over(true);
  EXPECT_THAT(Fix(CheckNodes), HasSubstr("queue=hgros.KeepLast(1)"));
  EXPECT_THAT(Say(CheckNodes),
              ElementsAre(HasSubstr(
                  "listener:2 match drops 80 of 100 messages per second of \"scan\", because its queue of 4 is full")));
  node.set_dropped(0);
  node.set_run_sum_ns(10'000'000);
  EXPECT_THAT(Say(CheckNodes),
              ElementsAre(HasSubstr("The queue of listener:2 match on \"scan\" is always full (4 messages)")));
  node.set_queued(0);
  node.set_failed(2);
  EXPECT_THAT(Say(CheckNodes), ElementsAre(HasSubstr("ends with exceptions (2 since the last look)")));
}

TEST_F(DoctorChecks, NameForbiddenChannelsAndListsOfEndpoints) {
  AddChannel("scan", true, true);
  Snapshot::Channel& scan = *Count(1, "scan").second;
  scan.set_not_leaving("Channel \"scan\" is published, but does not leave this host: no publisher endpoint has it.");
  EXPECT_THAT(
      Say(CheckForbidden),
      ElementsAre(
          "talker:1 publishes \"scan\", to which listener:2 subscribes, but no message passes. Channel \"scan\" is "
          "published, but does not leave this host: no publisher endpoint has it."));
  MeetOver("shared memory");
  EXPECT_THAT(Say(CheckForbidden), IsEmpty());
  scan.set_not_leaving("Channel \"scan\" stays.");  // The text does not matter.
  scan.set_forbidden(true);
  EXPECT_THAT(
      Say(CheckForbidden),
      ElementsAre("talker:1 publishes \"scan\", to which listener:2 subscribes, but no message passes. In talker:1: "
                  "Channel \"scan\" stays."));
}

TEST_F(DoctorChecks, NameChannelsThatBothEndsForbidOnce) {
  Snapshot::Channel& out = *Count(1, "scan").second;
  out.set_not_leaving("It stays.");
  out.set_forbidden(true);
  Snapshot::Channel& in = *Count(2, "scan").second;
  in.set_not_entering("It stays.");
  in.set_forbidden(true);
  EXPECT_THAT(Say(CheckForbidden),
              ElementsAre(HasSubstr("talker:1 publishes \"scan\", to which listener:2 subscribes"),
                          HasSubstr("listener:2 subscribes to \"scan\", which talker:1 publishes")));
  AddChannel("scan", false, true);  // A forbidden channel is not announced by its publisher.
  EXPECT_THAT(Say(CheckChannels), IsEmpty());
}

TEST_F(DoctorChecks, NameClosedChannelsWhoseNodesHearNothing) {
  const auto [before, after] = Count(1, "scan");
  after->add_nodes()->set_name("match");
  after->set_closed(true);
  EXPECT_THAT(Say(CheckForbidden), IsEmpty()) << "nothing is published";
  after->set_published(10);
  EXPECT_THAT(Say(CheckForbidden), ElementsAre(HasSubstr("the channel is closed there: its match gets nothing.")));
  after->set_received(10);
  EXPECT_THAT(Say(CheckForbidden), IsEmpty()) << "another session sends the messages";
}

// A name may be anything, and users copy the command into a shell.
TEST_F(DoctorChecks, QuoteNamesInCommands) {
  evidence.names[SessionId{1}] = "talker's:1";
  Snapshot::Channel& channel = *Count(1, "x;`reboot`").second;
  AddChannel("x;`reboot`", true, true);
  channel.set_not_leaving("It stays.");
  channel.set_forbidden(true);
  EXPECT_EQ(Fix(CheckForbidden), "hgros control allow 'x;`reboot`' --session 'talker'\\''s:1'");
}

TEST_F(DoctorChecks, NameSocketsOnOneHostClocksAndVersions) {
  AddChannel("scan", true, true);
  MeetOver("ZeroMQ", "another user");
  const_cast<Snapshot&>(*evidence.after[SessionId{1}]).set_version("2");
  evidence.offsets[SessionId{2}].offset = std::chrono::milliseconds(-30);
  EXPECT_THAT(Say(CheckSessions, Severity::kNote),
              ElementsAre("talker:1 and listener:2 are on one host, but exchange messages over ZeroMQ: another user.",
                          "The clock of robot is 30.0 ms behind this host's.",
                          "Sessions use different versions of the library: 1 in listener:2; 2 in talker:1."));
}

TEST_F(DoctorChecks, AdviseAgainstTheCauseOfSocketsOnOneHost) {
  AddChannel("scan", true, true);
  const auto advice = [&](const std::string& why) {
    MeetOver("ZeroMQ", why);
    return Fix(CheckSessions);
  };
  EXPECT_THAT(advice("not found on this host"), HasSubstr("one user"));
  EXPECT_THAT(advice("discovery on this host is off"), HasSubstr("discovery: {local: true}"));
  EXPECT_THAT(advice("shared memory does not reach it yet"), HasSubstr("in their logs"));
}

TEST_F(DoctorChecks, BearCountersThatAreMissingOrRunBackwards) {
  AddChannel("scan", true, true);
  const auto [before, after] = Count(2, "scan");
  before->add_nodes()->set_name("match");
  before->mutable_nodes(0)->set_received(10);
  after->add_nodes()->set_name("match");
  before->set_lost(10);
  evidence.before.erase(SessionId{1});
  EXPECT_THAT(Say(CheckNodes), IsEmpty());
  EXPECT_THAT(Say(CheckChannels), IsEmpty());
  evidence.after.clear();
  EXPECT_THAT(Say(CheckSessions), IsEmpty());
}

}  // namespace
}  // namespace hgros::cli
