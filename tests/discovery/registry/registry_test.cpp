#include "hgros/discovery/registry.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <fstream>
#include <optional>
#include <random>

#include "discovery/listening.hpp"
#include "hgros/base/error.hpp"
#include "support/seed.hpp"

namespace hgros::discovery::registry_test {
namespace {

using test::Await;
namespace fs = std::filesystem;

struct Registered : Participant {
  explicit Registered(const RegistryOptions& options, const std::string& process = "test")
      : Participant([&](auto& listener, Log& kept) { return OpenRegistry(options, listener, kept); }, process) {}
};

class Registry : public testing::Test, protected OwnDomain {};

TEST_F(Registry, ReportsEveryOtherSessionAndEarlierOnesBeforeItIsOpenButNotItself) {
  Registered one(options, "one");
  Registered two(options, "two");
  one.Announce();
  two.Announce();
  EXPECT_TRUE(one.listening.AwaitPeer(two.own));
  EXPECT_TRUE(two.listening.AwaitPeer(one.own));
  Registered late(options, "late");
  for (const Registered* early : {&one, &two}) {
    EXPECT_TRUE(late.listening.Sees(early->own)) << "it was reported before OpenRegistry() returned";
  }
  EXPECT_EQ(late.discovery->List(), late.listening.here());
  late.Announce();
  EXPECT_TRUE(one.listening.AwaitPeer(late.own));
  EXPECT_TRUE(two.listening.AwaitPeer(late.own));
  for (const Registered* participant : {&one, &two, &late}) {
    EXPECT_EQ(participant->listening.came(participant->own.session), 0);
    EXPECT_EQ(participant->discovery->List(), participant->listening.here());
    EXPECT_EQ(participant->log.text(), "");
  }
}

TEST_F(Registry, RemovesFoldersOfDeadSessions) {
  const auto leave = [&](const std::string& domain, const std::string& file) {
    fs::create_directories(options.folder / domain);
    fs::permissions(options.folder / domain, fs::perms::owner_all);
    std::ofstream(options.folder / domain / file) << "x";
  };
  fs::create_directory(options.folder);
  fs::permissions(options.folder, fs::perms::owner_all);
  leave("dead", "0123456789abcdef");
  leave("dead", ".0123456789abcdee.0123456789abcdef");
  leave("strange", "0123456789abcdef");
  leave("strange", "README");
  const Registered living(RegistryOptions{options.folder, "alive"});
  living.Announce();
  leave("alive", "0123456789abcdef");
  const Registered newcomer(options);
  EXPECT_TRUE(Await([&] { return !fs::exists(options.folder / "dead"); }));
  EXPECT_TRUE(fs::exists(options.folder / "strange" / "README"));
  EXPECT_TRUE(fs::exists(options.folder / "strange" / "0123456789abcdef")) << "a file of unknown origin must stay";
  EXPECT_TRUE(fs::exists(options.folder / "alive" / living.own.session.ToString()));
}

TEST_F(Registry, ReportsChangesAndARestart) {
  const Registered observer(options);
  Registered changing(options);
  changing.Announce();
  ASSERT_TRUE(observer.listening.AwaitPeer(changing.own));
  for (int i = 0; i < 20; ++i) {
    changing.own.channels.push_back(
        {ChannelUse{"channel" + std::to_string(i), "Type", Encoding::kCustom, 0, true, true, false}});
    changing.Announce();
  }
  EXPECT_TRUE(observer.listening.AwaitPeer(changing.own));
  changing.own.channels.clear();
  changing.own.endpoints = {"tcp://*:1"};
  changing.Announce();
  EXPECT_TRUE(observer.listening.AwaitPeer(changing.own));
  EXPECT_EQ(observer.listening.came(changing.own.session), 1);
  changing.own.incarnation = 2;
  changing.Announce();
  EXPECT_TRUE(observer.listening.AwaitPeer(changing.own));
  EXPECT_EQ(observer.listening.came(changing.own.session), 2);
}

TEST_F(Registry, ReportsGoodbyesAndTheLastSessionRemovesTheFolder) {
  std::optional<Registered> observer(options);
  std::optional<Registered> leaving(options);
  leaving->Announce();
  const Announcement left = leaving->own;
  ASSERT_TRUE(observer->listening.AwaitPeer(left));
  leaving.reset();
  ASSERT_TRUE(observer->listening.AwaitCount(0));
  EXPECT_EQ(observer->listening.gone(left.session), "It said goodbye.");
  EXPECT_TRUE(Await([&] { return fs::exists(folder); })) << "another registry still watches the folder";
  observer.reset();
  EXPECT_FALSE(fs::exists(folder));
}

TEST_F(Registry, FindsSessionsAfterTheEmptyFolderWasRemoved) {
  Registered observer(options);
  { const Registered brief(options); }
  Registered next(options);
  next.Announce();
  EXPECT_TRUE(observer.listening.AwaitPeer(next.own));
  observer.Announce();
  EXPECT_TRUE(next.listening.AwaitPeer(observer.own));
  EXPECT_EQ(observer.log.text() + next.log.text(), "");
}

TEST_F(Registry, LetsItsListenerAnnounceAndList) {
  Registered caller(options);
  std::atomic<std::size_t> listed = 0;
  caller.listening.on_came = [&] {
    caller.Announce();
    listed = caller.discovery->List().size();
  };
  const Registered other(options);
  other.Announce();
  EXPECT_TRUE(other.listening.AwaitPeer(caller.own));
  EXPECT_TRUE(Await([&] { return listed == 1U; }));
}

TEST_F(Registry, RefusesASessionIdThatIsAlreadyAnnounced) {
  const Registered first(options);
  first.Announce();
  Registered second(options);
  second.own.session = first.own.session;
  EXPECT_THROW(second.Announce(), Error);
  second.own.session = SessionId::Random();
  EXPECT_NO_THROW(second.Announce());
}

TEST_F(Registry, RefusesAnnouncementsThatCannotBeRead) {
  Registered one(options);
  const Announcement good = one.own;
  one.own.session = {};
  EXPECT_THROW(one.Announce(), Error);
  one.own = good;
  one.own.channels.resize(20'000, {{std::string(200, 'c'), "Type", Encoding::kPlain, 1, true, true, true}, {}});
  EXPECT_THROW(one.Announce(), Error);
  one.own = good;
  one.Announce();
  one.own.session = SessionId::Random();
  EXPECT_THROW(one.Announce(), Error) << "one registry, one session";
  one.own = good;
  one.own.channels = {{ChannelUse{"not a name", "Type", Encoding::kPlain, 1, true, true, true}}};
  EXPECT_THROW(one.Announce(), Error);
}

TEST_F(Registry, RestoresARemovedFile) {
  const Registered observer(options);
  const Registered careless(options);
  careless.Announce();
  ASSERT_TRUE(observer.listening.AwaitPeer(careless.own));
  const fs::path file = folder / careless.own.session.ToString();
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(fs::remove(file));
    EXPECT_TRUE(Await([&] { return fs::exists(file); }));
  }
  EXPECT_EQ(careless.log.Count({"written again", file.string()}), 1U) << careless.log.text();
  EXPECT_EQ(observer.listening.gone(careless.own.session), "") << "it was present all the time";
}

TEST_F(Registry, RestoresARemovedFolder) {
  std::deque<Registered> all;
  for (int i = 0; i < 4; ++i) all.emplace_back(options).Announce();
  for (const auto& one : all) ASSERT_TRUE(one.listening.AwaitCount(3));
  for (int i = 0; i < 3; ++i) {
    std::error_code busy;  // Files may be restored before this has finished.
    fs::remove_all(options.folder, busy);
    for (const auto& one : all) {
      EXPECT_TRUE(Await([&] { return fs::exists(folder / one.own.session.ToString()); }));
    }
  }
  const Registered late(options);
  late.Announce();
  EXPECT_EQ(late.discovery->List().size(), 4U);
  for (const auto& one : all) {
    EXPECT_TRUE(one.listening.AwaitCount(4));
    EXPECT_EQ(one.log.Count({"written again"}), 1U) << one.log.text();
  }
}

TEST_F(Registry, DropsASessionWhoseFileIsNotRestored) {
  const Registered observer(options);
  std::optional<Registered> lost(options);
  lost->Announce();
  const Announcement own = lost->own;
  ASSERT_TRUE(observer.listening.AwaitPeer(own));
  fs::rename(folder, scratch / "moved");
  lost.reset();
  EXPECT_TRUE(observer.listening.AwaitCount(0));
  EXPECT_NE(observer.listening.gone(own.session), "");
}

TEST_F(Registry, RescansTheFolderAfterTheEventQueueOverflowed) {
  std::ifstream limit_file("/proc/sys/fs/inotify/max_queued_events");
  int limit = 0;
  limit_file >> limit;
  if (limit <= 0 || limit > 200'000) GTEST_SKIP() << "the kernel keeps " << limit << " events";
  test::Door door;
  Registered slow(options);
  std::atomic<bool> blocked = false;
  slow.listening.on_came = [&] {
    blocked = true;
    door.Pass();
  };
  std::optional<Registered> leaving(options);
  leaving->Announce();
  ASSERT_TRUE(Await([&] { return blocked.load(); }));
  std::ofstream(folder / "a") << "not a session";
  for (int i = 0; i <= limit / 4; ++i) {
    fs::rename(folder / "a", folder / "b");
    fs::rename(folder / "b", folder / "a");
  }
  leaving.reset();
  const Registered coming(options);
  coming.Announce();
  door.Open();
  EXPECT_TRUE(Await([&] { return slow.discovery->List() == std::vector{coming.own}; }));
  EXPECT_TRUE(slow.listening.AwaitCount(1));
  fs::remove(folder / "a");
}

TEST_F(Registry, AgreesWithAModelUnderRandomChanges) {
  std::mt19937 random(test::Seed());
  const Registered observer(options);
  std::vector<std::unique_ptr<Registered>> all(8);
  for (int step = 0; step < 300; ++step) {
    auto& one = all[random() % all.size()];
    switch (random() % 4) {
      case 0: one.reset(); break;
      case 1: one = std::make_unique<Registered>(options); break;
      default:
        if (one == nullptr) one = std::make_unique<Registered>(options);
        one->own.channels.resize(random() % 3, {{"c", "T", Encoding::kPlain, random(), true, false, false}, {}});
        one->Announce();
    }
  }
  for (const auto& one : all) {
    if (one == nullptr) continue;
    one->Announce();
    EXPECT_TRUE(observer.listening.AwaitPeer(one->own));
  }
  for (const auto& one : all) {
    if (one == nullptr) continue;
    EXPECT_TRUE(Await([&] { return one->discovery->List().size() == observer.discovery->List().size() - 1; }));
  }
  all.clear();
  EXPECT_TRUE(observer.listening.AwaitCount(0));
  EXPECT_TRUE(IsEmptyOrGone(folder));
  EXPECT_EQ(observer.log.text(), "");
}

}  // namespace
}  // namespace hgros::discovery::registry_test
