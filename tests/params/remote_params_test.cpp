#include "hgros/params/remote_params.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <array>
#include <future>

#include <hgros/Params.pb.h>

#include "hgros/params/param_service.hpp"
#include "session/domain_fixture.hpp"

namespace hgros {
namespace {

using namespace std::chrono_literals;
using test::Await;
using test::Bus;
using test::kPatience;
using test::Robot;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<ParamOverride> Values() {
  return {{"slam.matcher.range", "8.5", "test"},
          {"slam.matcher.method", "icp", "test"},
          {"slam.gains", "[1, 2]", "test"},
          {"a.\"the key\"", "\"5\"", "test"}};
}

// A session that offers its parameters.
struct Offering {
  explicit Offering(Session& session) {
    server.Declare("slam.matcher.range", 1.0,
                   {.description = "how far the laser sees", .unit = "m", .least = 0, .most = 30});
    server.Declare("slam.matcher.method", std::string("icp"), {.choices = {"icp", "ndt"}});
    validator = server.AddValidator("slam.gains", [](const ParamEvent& event) -> std::optional<std::string> {
      if (event.after.Get<std::vector<int>>("slam.gains").size() < 4) return std::nullopt;
      return "The matcher takes three gains.";
    });
    service.emplace(session, server, "robot");
  }

  ParamServer server{ParamSources{{}, Values()}};
  Listening validator;
  std::optional<ParamService> service;
};

// The program: another session reads, sets and watches them.
void UseFrom(Session& session) {
  RemoteParams params(session, "robot", kPatience);
  EXPECT_EQ(*params.Get<double>("slam.matcher.range"), 8.5);
  EXPECT_THAT(*params.List(), ElementsAre("slam.matcher.range", "slam.matcher.method", "slam.gains", "a.\"the key\""));
  EXPECT_THAT(*params.List("slam.matcher"), ElementsAre("slam.matcher.range", "slam.matcher.method"));

  std::atomic<int> changes{0};
  std::atomic<double> seen{0};
  const auto watching = params.Watch("slam.matcher", [&](const ParamEvent& event) {
    ++changes;  // Before what shows that it came.
    seen = event.after.Get<double>("slam.matcher.range");
  });
  EXPECT_TRUE(Await([&] { return seen == 8.5; })) << "a watch begins with the current values";
  const int before = changes;
  EXPECT_EQ(params.Set("slam.gains", std::array{3, 4, 5}).refusal, "");
  EXPECT_EQ(params.Set("slam.matcher.range", 12.25).refusal, "");
  EXPECT_EQ(*params.Get<double>("slam.matcher.range"), 12.25) << "the new value is read";
  EXPECT_TRUE(Await([&] { return seen == 12.25; }));
  EXPECT_EQ(changes, before + 1) << "the gains are not watched";

  EXPECT_EQ(params.Set("slam.matcher.range", 40).refusal,
            "set while running: slam.matcher.range must be from 0.0 to 30.0 m, but is the number 40.");
  EXPECT_EQ(params.Set("slam.gains", std::array{1, 2, 3, 4}).refusal, "The matcher takes three gains.");
  EXPECT_FALSE(
      params.Change({ParamChange::Of("slam.matcher.range", 5.0), ParamChange::Of("slam.matcher.method", 7)}).ok());
  EXPECT_EQ(*params.Get<double>("slam.matcher.range"), 12.25) << "all changes or none";
  EXPECT_TRUE(params
                  .Change({ParamChange::Of("slam.matcher.range", 5.0),
                           ParamChange::Of("slam.matcher.method", std::string("ndt"))})
                  .ok());
  EXPECT_EQ(*params.Get<std::string>("slam.matcher.method"), "ndt");
  EXPECT_TRUE(params.Remove("slam.matcher.range").ok());
  EXPECT_EQ(*params.Get<double>("slam.matcher.range"), 1.0) << "the default";

  const auto described = params.Describe("slam");
  ASSERT_TRUE(described.ok()) << described.refusal;
  ASSERT_EQ(described->size(), 2U);
  EXPECT_EQ(described->at(0).path, "slam.matcher.range");
  const ParamInfo range{.description = "how far the laser sees", .unit = "m", .least = 0, .most = 30};
  EXPECT_EQ(described->at(0).info, range);
  EXPECT_EQ(described->at(0).type, "number");
  EXPECT_EQ(described->at(0).fallback, "1.0");
  EXPECT_THAT(described->at(1).info.choices, ElementsAre("icp", "ndt"));
  EXPECT_TRUE(params.Describe("a")->empty());
}

struct Placement {
  std::string name;
  std::string robot;
  std::optional<std::string> other;  // Empty: the same session.
};
void PrintTo(const Placement& placement, std::ostream* out) { *out << placement.name; }

const Bus& TheBus() {
  static const Bus bus;
  return bus;
}

class RemoteParamsOnEveryTransport : public test::DomainFixture, public testing::WithParamInterface<Placement> {};

TEST_P(RemoteParamsOnEveryTransport, AreReadSetAndWatched) {
  Robot robot(GetParam().robot);
  std::optional<Robot> other;
  if (GetParam().other) {
    other.emplace(*GetParam().other, "other");
    for (const std::string& endpoint : robot->PublisherEndpoints()) {
      other->session->AddSubscriberEndpoint({endpoint, {}, true});
    }
    for (const std::string& endpoint : other->session->PublisherEndpoints()) {
      robot->AddSubscriberEndpoint({endpoint, {}, true});
    }
  }
  const Offering offering(*robot.session);
  UseFrom(other ? *other->session : *robot.session);
}

constexpr auto kTcp = "network: {publisher: {ip: 'tcp://127.0.0.1:*'}}\ndiscovery: {local: false}";
INSTANTIATE_TEST_SUITE_P(Placed, RemoteParamsOnEveryTransport,
                         testing::Values(Placement{"pointer", "", std::nullopt}, Placement{"sharedmemory", "", ""},
                                         Placement{"ipc", TheBus().Publishing("robot") + "discovery: {local: false}",
                                                   TheBus().Publishing("other") + "discovery: {local: false}"},
                                         Placement{"tcp", kTcp, kTcp}),
                         [](const auto& placed) { return placed.param.name; });

class RemoteParamsTest : public test::DomainFixture {
 protected:
  Robot robot_{"", "robot"};
  Robot other_{"", "other"};
  RemoteParams params_{*other_.session, "robot", kPatience};
};

class OfferedParams : public RemoteParamsTest {
 protected:
  Offering offering_{*robot_.session};
};

TEST_F(OfferedParams, AWatchOfAPathThatDoesNotExistIsLoggedOnceWithTheNearestOne) {
  test::Lines lines;
  RemoteParams params(*other_.session, "robot", kPatience, lines.Sink());
  std::atomic<int> changes{0};
  const auto count = [&](const ParamEvent&) { ++changes; };
  const auto everything = params.Watch("", count);
  const auto map = params.Watch("slam.matcher", count);
  const auto wrong = params.Watch("slam.macher", count);
  EXPECT_TRUE(Await([&] { return changes == 3 && lines.all().size() == 1; })) << "each watch begins with all values";
  EXPECT_TRUE(params.Set("slam.matcher.range", 3.0).ok());
  EXPECT_TRUE(Await([&] { return changes == 5; }));
  EXPECT_THAT(lines.all(),
              ElementsAre("A watch waits for the parameter slam.macher, which the session \"robot\" does not have so "
                          "far. Did you mean slam.matcher?"));
}

TEST_F(OfferedParams, ReportsWhenNoSessionOffersThem) {
  ASSERT_TRUE(params_.Snapshot().ok());
  RemoteParams params(*other_.session, "robt", 20ms);
  constexpr auto kSentence = "No session \"robt\" offers parameters. Did you mean \"robot\"?";
  EXPECT_EQ(params.Get<int>("a").refusal, kSentence);
  EXPECT_EQ(params.List().refusal, kSentence);
  EXPECT_EQ(params.Describe().refusal, kSentence);
  EXPECT_EQ(params.Set("a", 1).refusal, kSentence);
  EXPECT_THROW(RemoteParams(*other_.session, "no channel name", 20ms), Error);
}

TEST_F(OfferedParams, ReportsMissingValuesAndWrongTypesAndCreatesNothingUnlessAsked) {
  EXPECT_THAT(params_.Get<double>("slam.matcher.reach").refusal, HasSubstr("slam.matcher.reach is not set"));
  EXPECT_THAT(params_.Get<int>("slam.matcher.method").refusal, HasSubstr("slam.matcher.method must be"));
  EXPECT_FALSE(params_.List("slam..x").ok());
  EXPECT_FALSE(params_.Describe("slam..x").ok());
  EXPECT_FALSE(params_.Set("slam..x", 1).ok());
  EXPECT_TRUE(params_.List("nothing")->empty());
  EXPECT_EQ(*params_.Get<std::string>("a.\"the key\""), "5") << "a text stays a text";

  EXPECT_EQ(params_.Set("slam.matcher.rnage", 5.0).refusal,
            "There is no parameter slam.matcher.rnage. Did you mean slam.matcher.range? To create it, pass "
            "IfMissing::kCreate.");
  EXPECT_EQ(params_.Remove("nothing").refusal, "There is no parameter nothing.");
  EXPECT_FALSE(params_.Change({ParamChange::Of("slam.matcher.range", 5.0), ParamChange::Of("new", 1)}).ok());
  EXPECT_EQ(*params_.Get<double>("slam.matcher.range"), 8.5) << "all changes or none";
  EXPECT_FALSE(params_.Get<int>("new").ok());
  EXPECT_EQ(params_.Set("new", 1, IfMissing::kCreate).refusal, "");
  EXPECT_EQ(params_.Set("new", 2).refusal, "");
  EXPECT_EQ(*params_.Get<int>("new"), 2);
}

TEST_F(OfferedParams, ReportsTimeouts) {
  test::Door door;
  const auto validator = offering_.server.AddValidator("slow", [&](const ParamEvent&) -> std::optional<std::string> {
    door.Pass();
    return std::nullopt;
  });
  ASSERT_TRUE(params_.Snapshot().ok());
  RemoteParams hurried(*other_.session, "robot", 50ms);
  EXPECT_THAT(hurried.Set("slow", 1, IfMissing::kCreate).refusal,
              HasSubstr("The session \"robot\" did not answer in time"));
  door.Open();
  EXPECT_EQ(*params_.Get<int>("slow"), 1) << "the change was made after the timeout";
}

TEST_F(OfferedParams, ShowsLaterDeclarationsAndChanges) {
  ASSERT_TRUE(params_.Snapshot().ok());
  offering_.server.Declare("later", 7, {.read_only = true});
  EXPECT_EQ(*params_.Get<int>("later"), 7);
  EXPECT_TRUE(params_.Describe("later")->at(0).info.read_only);
  EXPECT_FALSE(params_.Set("later", 8).ok());
  std::atomic<int> seen{0};
  const auto watching = params_.Watch("x", [&](const ParamEvent& event) { seen = event.after.Get<int>("x", -1); });
  for (int i = 1; i <= 20; ++i) {
    ASSERT_TRUE(offering_.server.Set("x", i).ok());
    ASSERT_EQ(*params_.Get<int>("x"), i);
    ASSERT_TRUE(Await([&] { return seen == i; }));
  }
}

TEST_F(OfferedParams, SlowListenerGetsTheLatestValue) {
  test::Door door;
  std::atomic<std::uint64_t> version{0};
  std::atomic<int> states{0};
  const Subscription slow = robot_->FromAny<ParamsState>("params/robot/state", Invoke::kSerial,
                                                         [&](const ParamsState& state) {
                                                           door.Pass();
                                                           version = state.version();
                                                           ++states;
                                                         },
                                                         {{}, Queue::KeepAll(1), Executor::Dedicated()});
  for (int i = 1; i <= 30; ++i) ASSERT_TRUE(offering_.server.Set("x", i).ok()) << "Set does not wait";
  door.Open();
  EXPECT_TRUE(Await([&] { return version == 31; }));
  EXPECT_LT(states, 31);
  RemoteParams late(*other_.session, "robot", kPatience);
  EXPECT_EQ(*late.Get<int>("x"), 30);
  for (int i = 31; i <= 40; ++i) ASSERT_TRUE(offering_.server.Set("x", i).ok());
  EXPECT_TRUE(Await([&] { return version == 41; }));
}

TEST_F(RemoteParamsTest, RecoversWhenTheOfferingSessionReturns) {
  RemoteParams impatient(*other_.session, "robot", 20ms);
  std::atomic<int> seen{0};
  const auto watching = params_.Watch("x", [&](const ParamEvent& event) { seen = event.after.Get<int>("x", -1); });
  for (int life = 1; life <= 3; ++life) {
    ParamServer server({{}, {{"x", std::to_string(life), "test"}}});
    const ParamService service(*robot_.session, server);
    EXPECT_EQ(*params_.Get<int>("x"), life);
    EXPECT_TRUE(Await([&] { return seen == life; }));
  }
  EXPECT_TRUE(Await([&] { return !impatient.Get<int>("x").ok(); }));
}

TEST_F(OfferedParams, CanBeSetInsideAListenerAndByManyThreadsAtOnce) {
  const auto counting = params_.Watch("count", [&](const ParamEvent& event) {
    const int count = event.after.Get<int>("count");
    if (count < 5) {
      EXPECT_EQ(params_.Set("count", count + 1).refusal, "");
    }
  });
  EXPECT_TRUE(params_.Set("count", 1, IfMissing::kCreate).ok());
  EXPECT_TRUE(Await([&] { return offering_.server.Get<int>("count") == 5; }));
  std::vector<std::jthread> setters;
  for (int t = 0; t < 4; ++t) {
    setters.emplace_back([&, t] {
      RemoteParams params(t % 2 == 0 ? *other_.session : *robot_.session, "robot", kPatience);
      const std::string path = "many.of" + std::to_string(t);
      for (int i = 1; i <= 25; ++i) {
        ASSERT_EQ(params.Set(path, i, IfMissing::kCreate).refusal, "");
        ASSERT_EQ(*params.Get<int>(path), i);
      }
    });
  }
  setters.clear();
  for (int t = 0; t < 4; ++t) EXPECT_EQ(offering_.server.Get<int>("many.of" + std::to_string(t)), 25);
}

TEST_F(RemoteParamsTest, WaitsNotForTheStateOfASessionThatHasEnded) {
  const auto answer = robot_->Advertise<ParamsAnswer>("params/robot/answer");
  std::atomic<bool> answered{false};
  std::optional<Subscription> asked;
  asked.emplace(
      robot_->FromAny<ParamsQuestion>("params/robot/ask", Invoke::kSerial, [&](const ParamsQuestion& question) {
        ParamsAnswer said;
        said.set_asker(question.asker());
        said.set_number(question.number());
        said.set_life(1);
        said.set_version(1);
        EXPECT_EQ(answer(said), PublishStatus::kOk);
        answered = true;
      }));
  RemoteParams params(*other_.session, "robot", 10 * kPatience);
  ASSERT_TRUE(robot_->WaitForSubscribers("params/robot/answer", 1, kPatience));
  auto refusal = std::async([&] { return params.Snapshot().refusal; });
  ASSERT_TRUE(Await([&] { return answered.load(); }));
  asked.reset();
  EXPECT_EQ(refusal.get(), "The session \"robot\" has ended after its answer, and its parameters have not arrived.");
}

TEST_F(OfferedParams, RefusesRequestsThatCannotBeReadAndMakesARepeatedChangeOnlyOnce) {
  const auto ask = other_->Advertise<ParamsQuestion>("params/robot/ask");
  std::atomic<int> refused{0};
  std::atomic<int> made{0};
  const auto answers =
      other_->FromAny<ParamsAnswer>("params/robot/answer", Invoke::kSerial, [&](const ParamsAnswer& answer) {
        EXPECT_EQ(answer.asker(), 1U);
        ++(answer.refusal().empty() ? made : refused);
      });
  ASSERT_TRUE(other_->WaitForSubscribers("params/robot/ask", 1, kPatience));
  ASSERT_TRUE(other_->WaitForPublishers("params/robot/answer", 1, kPatience));
  ParamsQuestion question;
  question.set_asker(1);
  question.set_create(true);
  question.add_changes();
  const auto change = [&](const std::string& path, const std::string& yaml) {
    question.set_number(question.number() + 1);
    question.mutable_changes(0)->set_path(path);
    question.mutable_changes(0)->set_yaml(yaml);
    EXPECT_EQ(ask(question), PublishStatus::kOk);
  };
  const std::array<std::pair<std::string, std::string>, 4> wrong{
      {{"a.b", "[1, 2"}, {"a..b", "1"}, {"a[9]", "1"}, {"x", "a: &a [*a]"}}};
  for (const auto& [path, yaml] : wrong) change(path, yaml);
  EXPECT_TRUE(Await([&] { return refused == 4; })) << refused;
  EXPECT_EQ(made, 0);
  change("x", "1");
  ASSERT_TRUE(Await([&] { return made >= 1; }));
  ASSERT_TRUE(offering_.server.Set("x", 2).ok());
  (void)ask(question);
  ASSERT_TRUE(Await([&] { return made >= 2; }));
  EXPECT_EQ(offering_.server.Get<int>("x"), 2);
  EXPECT_EQ(refused, 4);
}

TEST_F(RemoteParamsTest, EndsTheWaitForASessionThatIsNotThere) {
  RemoteParams nobody(*robot_.session, "nobody", 1h);  // Longer than the test may take.
  auto waits = std::async(std::launch::async, [&] { return nobody.Snapshot().refusal; });
  test::Linger(50ms);
  nobody.EndWaits();
  EXPECT_THAT(waits.get(), HasSubstr("The wait for the session \"nobody\" was ended."));
  EXPECT_THAT(nobody.Snapshot().refusal, HasSubstr("was ended."));
}

// Both answer, and the answer of one may come with the state of the other.
TEST_F(RemoteParamsTest, SetsWhatTwoServicesWithTheSameNameOffer) {
  const auto quiet = [](LogLevel, std::string_view) {};
  ParamServer one;
  ParamServer two;
  const ParamService first(*robot_.session, one, "robot", quiet);
  const ParamService second(*other_.session, two, "robot", quiet);
  ASSERT_TRUE(other_->WaitForSubscribers("params/robot/ask", 2, kPatience));
  for (int i = 1; i <= 20; ++i) {
    ASSERT_EQ(params_.Set("x", i, IfMissing::kCreate).refusal, "");
    ASSERT_TRUE(Await([&] { return one.Get<int>("x", -1) == i && two.Get<int>("x", -1) == i; }));
  }
}

// Whether one of two services with one name says a line with this text.
bool OneSays(Session& first, Session& second, std::string_view text) {
  test::Lines lines;
  ParamServer server;
  const ParamService one(first, server, "robot", lines.Sink());
  const ParamService two(second, server, "robot", lines.Sink());
  return Await([&] { return lines.Contains(text); });
}

TEST_F(RemoteParamsTest, ReportsTwoServicesWithTheSameName) {
  EXPECT_TRUE(OneSays(*robot_.session, *other_.session,
                      ":" + std::to_string(getpid()) +
                          " also offers parameters as \"robot\". Rename one, or give each " +
                          "robot its own HGROS_DOMAIN."));
  EXPECT_TRUE(OneSays(*robot_.session, *robot_.session,
                      "This session offers parameters under the name \"robot\" more than once"));
}

}  // namespace
}  // namespace hgros
