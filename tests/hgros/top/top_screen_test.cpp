#include "top/top_screen.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

std::vector<std::string> TextOf(const Picture& picture) {
  std::vector<std::string> lines;
  for (const auto& spans : picture.lines) {
    std::string& line = lines.emplace_back();
    for (const Span& span : spans) line += span.text;
  }
  return lines;
}

std::string All(TopScreen& screen, int columns = 80, int lines = 24) {
  std::string all;
  for (const std::string& line : TextOf(screen.Draw(columns, lines))) all += line + "\n";
  return all;
}

// Sessions that publish on channels with these names.
Activity ActivityWith(const std::vector<std::string>& names) {
  std::vector<KnownChannel> channels;
  AllCounters counters;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string number = std::to_string(i);
    const auto pid = static_cast<std::int64_t>(i);
    const ChannelUser user{.session = {i + 1}, .process = "process" + number, .host = {}, .pid = pid, .type_name = {}};
    channels.push_back({.name = names[i], .type_name = "foxglove.Log", .publishers = {user}, .subscribers = {}});
    auto snapshot = std::make_shared<Snapshot>();
    snapshot->set_session(i + 1);
    snapshot->set_steady_ns(1);
    Snapshot::Channel* counted = snapshot->add_channels();
    counted->set_name(names[i]);
    counted->set_rate_hz(static_cast<double>(i + 1));
    counted->add_nodes()->set_name("node" + number);
    counters[user.session] = snapshot;
  }
  Activity activity({}, false);
  activity.Update(counters, channels);
  return activity;
}

TopScreen ScreenWith(const std::vector<std::string>& names, TopKind kind = TopKind::kChannels) {
  TopScreen screen(kind, [](const TopRow& row) { return "all about " + Visible(row.channel) + "\nsecond line"; });
  screen.Show(ActivityWith(names));
  return screen;
}

// What it shows after a key.
std::string After(TopScreen& screen, const KeyPress& press) {
  EXPECT_TRUE(screen.Press(press));
  return All(screen);
}

TEST(TopScreen, ShowsTheListsInTurn) {
  TopScreen screen = ScreenWith({"scan", "odom"}, TopKind::kSessions);
  EXPECT_THAT(All(screen), HasSubstr("process0:0"));
  EXPECT_THAT(After(screen, {Key::kTab}), HasSubstr("node1"));
  EXPECT_THAT(After(screen, {Key::kTab}), HasSubstr("odom      2.00 Hz"));
  EXPECT_THAT(After(screen, {Key::kBackTab}), HasSubstr("NODE "));
  EXPECT_THAT(After(screen, {Key::kText, "1"}), HasSubstr("SESSION "));
}

TEST(TopScreen, FiltersWhileATextIsTyped) {
  TopScreen screen = ScreenWith({"scan", "odom", "quiet"});
  for (const char* key : {"/", "q"}) EXPECT_THAT(After(screen, {Key::kText, key}), HasSubstr("quiet"));
  EXPECT_THAT(All(screen), Not(HasSubstr("scan")));
  EXPECT_THAT(After(screen, {Key::kText, "\xC3\xA9"}), HasSubstr("Nothing contains \"q\xC3\xA9\"."));
  EXPECT_TRUE(screen.Press({Key::kBackspace}));
  EXPECT_THAT(After(screen, {Key::kEnter}), HasSubstr("only with \"q\""));
  EXPECT_THAT(After(screen, {Key::kEscape}), HasSubstr("scan"));
  EXPECT_FALSE(screen.Press({Key::kText, "q"}));
}

TEST(TopScreen, ShowsDetailsOfTheSelectedRowAndGoesBack) {
  TopScreen screen = ScreenWith({"scan", "odom"});
  (void)All(screen);
  EXPECT_TRUE(screen.Press({Key::kDown}));
  EXPECT_THAT(After(screen, {Key::kEnter}), HasSubstr("all about scan\nsecond line"));
  EXPECT_THAT(After(screen, {Key::kText, "h"}), HasSubstr("Reverse the order"));
  EXPECT_THAT(After(screen, {Key::kEscape}), HasSubstr("all about scan"));
  EXPECT_THAT(After(screen, {Key::kEscape}), HasSubstr("CHANNEL"));
}

TEST(TopScreen, EndsWithQFromEachPage) {
  for (const std::vector<KeyPress>& before : std::vector<std::vector<KeyPress>>{{},
                                                                                {{Key::kEnter}},
                                                                                {{Key::kText, "h"}},
                                                                                {{Key::kEnter}, {Key::kText, "h"}},
                                                                                {{Key::kText, "/"}, {Key::kEnter}}}) {
    TopScreen screen = ScreenWith({"scan", "odom"});
    for (const KeyPress& press : before) EXPECT_TRUE(screen.Press(press));
    (void)All(screen);
    EXPECT_FALSE(screen.Press({Key::kText, "q"})) << before.size();
  }
}

TEST(TopScreen, NamesEveryKeyInItsHelp) {
  TopScreen screen = ScreenWith({"scan"});
  (void)screen.Press({Key::kF1});
  const std::string help = All(screen, 130, 50);
  for (const char* key : {"Tab", "PgDn", "Enter", "Esc", "/", "<", ">", "N ", "P ", "M ", "T ", "W ", "D ", "H ", "B ",
                          "R ", "h, F1 or ?", "q or Ctrl-C"}) {
    EXPECT_THAT(help, HasSubstr(key));
  }
}

TEST(TopScreen, EscapesWhatARobotNames) {
  TopScreen screen = ScreenWith({"\x1b[31mred\x07", "caf\xC3\xA9"});
  const std::string all = All(screen);
  EXPECT_EQ(all.find('\x1b'), std::string::npos);
  EXPECT_THAT(all, HasSubstr("\\x1b[31mred\\x07"));
  EXPECT_THAT(all, HasSubstr("caf\xC3\xA9"));
}

TEST(TopScreen, FitsEveryWindow) {
  std::vector<std::string> names;
  for (int i = 0; i < 30; ++i)
    names.push_back("channel" + std::to_string(i) + std::string(static_cast<std::size_t>(i * 5), 'x'));
  std::mt19937 random(4711);
  const std::vector<Key> keys{Key::kUp,   Key::kDown,  Key::kPageUp, Key::kPageDown, Key::kHome, Key::kEnd,
                              Key::kLeft, Key::kRight, Key::kEnter,  Key::kEscape,   Key::kTab,  Key::kBackspace};
  TopScreen screen = ScreenWith(names);
  const Activity none({}, false);
  const Activity some = ActivityWith(names);
  for (int i = 0; i < 3000; ++i) {
    const int columns = static_cast<int>(random() % 140) + 1;
    const int lines = static_cast<int>(random() % 30) + 1;
    const std::vector<std::string> text = TextOf(screen.Draw(columns, lines));
    EXPECT_LE(text.size(), static_cast<std::size_t>(lines));
    for (const std::string& line : text) EXPECT_LE(ColumnsOf(line), static_cast<std::size_t>(columns)) << line;
    if (random() % 8 == 0) screen.Show(random() % 2 == 0 ? none : some);
    KeyPress press{keys[random() % keys.size()]};
    if (random() % 4 == 0) press = {Key::kText, std::string(1, "/hRNPMTWDHB123x<>"[random() % 17])};
    ASSERT_TRUE(screen.Press(press)) << "seed 4711, step " << i;
  }
}

TEST(TopScreen, ShowsASentenceForAWhileOrUntilTheNextKey) {
  TopScreen screen = ScreenWith({"scan"});
  const Activity activity = ActivityWith({"scan"});
  screen.Tell("a session does not answer");
  EXPECT_THAT(All(screen), HasSubstr("\na session does not answer\n"));
  EXPECT_THAT(All(screen, 12), HasSubstr("\na session...\n"));
  for (int i = 0; i < 4; ++i) screen.Show(activity);
  EXPECT_THAT(All(screen), HasSubstr("does not answer"));
  screen.Show(activity);
  EXPECT_THAT(All(screen), Not(HasSubstr("does not answer")));
  screen.Tell("again");
  (void)screen.Press({Key::kDown});
  EXPECT_THAT(All(screen), Not(HasSubstr("again")));
}

TEST(TopScreen, SaysThatNothingIsThere) {
  TopScreen screen = ScreenWith({});
  EXPECT_THAT(All(screen), HasSubstr("No session is there."));
  EXPECT_THAT(After(screen, {Key::kEnter}), HasSubstr("No session is there."));
}

}  // namespace
}  // namespace hgros::cli
