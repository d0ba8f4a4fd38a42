#include "hgros/base/names.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "support/error_of.hpp"

namespace hgros {
namespace {

using ::testing::HasSubstr;

TEST(ChannelName, MayHaveSlashesAndUtf8) {
  for (const char* name :
       {"scan", "/scan", "robot1/scan", "a", "caméra/gauche", "激光", "\xf0\x9f\xa4\x96", "a.b:c-d_e#~"}) {
    EXPECT_EQ(ChannelNameFault(name), "") << name;
    EXPECT_NO_THROW(RequireChannelName(name));
  }
}

TEST(ChannelName, MayNotBeEmptyOrTooLong) {
  EXPECT_EQ(ChannelNameFault(""), "it is empty");
  EXPECT_EQ(ChannelNameFault(std::string(kMaxChannelNameLength, 'x')), "");
  EXPECT_EQ(ChannelNameFault(std::string(kMaxChannelNameLength + 1, 'x')), "it has 201 bytes, more than 200");
}

TEST(ChannelName, MayNotHaveSpacesOrControlCharacters) {
  for (int c = 0; c <= 0x20; ++c) {
    const std::string name{'a', static_cast<char>(c), 'b'};
    EXPECT_EQ(ChannelNameFault(name), "byte 2 is a space or control character") << c;
  }
  EXPECT_EQ(ChannelNameFault("ab\x7f"), "byte 3 is a space or control character");
}

TEST(ChannelName, MayNotHaveInvisibleCharactersThatChangeTheText) {
  constexpr auto kFault = "byte 2 begins a control character or one that changes the direction of text";
  for (const char* name :
       {"a\xc2\x80", "a\xc2\x85", "a\xc2\x9f", "a\xe2\x80\xaa", "a\xe2\x80\xae", "a\xe2\x81\xa6", "a\xe2\x81\xa9"}) {
    EXPECT_EQ(ChannelNameFault(name), kFault);
  }
}

TEST(ChannelName, MustBeUtf8) {
  const std::vector<std::string> bad = {
      "a\x80",              // a continuation byte alone
      "a\xc3",              // cut short
      "a\xc0\xaf",          // overlong in two bytes
      "a\xe0\x9f\xbf",      // overlong in three
      "a\xed\xa0\x80",      // a surrogate
      "a\xf0\x8f\xbf\xbf",  // overlong in four
      "a\xf4\x90\x80\x80",  // past U+10FFFF
      "a\xff",              // never a UTF-8 byte
      "a\xe2\x82 ",         // a space inside a character
  };
  for (const std::string& name : bad) EXPECT_EQ(ChannelNameFault(name), "byte 2 does not begin a UTF-8 character");
}

TEST(ChannelName, FaultIsThrownWithTheNameAndAnExample) {
  try {
    RequireChannelName("two words");
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("\"two words\""));
    EXPECT_THAT(error.what(), HasSubstr("byte 4 is a space"));
    EXPECT_THAT(error.mend(), HasSubstr("robot1/scan"));
  }
}

TEST(ChannelName, ErrorsContainNoControlCharacters) {
  const std::string error =
      test::ErrorOf([] { RequireChannelName("a\x1b[31m\xff" + std::string(63, 'b') + "\xc3\xa9"); });
  EXPECT_THAT(error, HasSubstr(R"("a\x1b[31m\xffb)"));
  EXPECT_EQ(error.find('\x1b'), std::string::npos);
  EXPECT_EQ(error.find('\xc3'), std::string::npos);
}

TEST(NearestName, FindsTheMostSimilarName) {
  const std::vector<std::string> keys = {"publisher", "subscribers", "ip", "channels", "close_channels"};
  EXPECT_EQ(NearestName("publishers", keys), "publisher");
  EXPECT_EQ(NearestName("subscriber", keys), "subscribers");
  EXPECT_EQ(NearestName("chanels", keys), "channels");
  EXPECT_EQ(NearestName("ipp", keys), "ip");
  EXPECT_EQ(NearestName("closed_channels", keys), "close_channels");
  EXPECT_EQ(NearestName("scna", std::vector<std::string>{"can", "scan"}), "scan")
      << "swapped letters count as one error";
  EXPECT_EQ(NearestName("camera_x", std::vector<std::string>{"camera_l", "camera_r"}), "camera_l")
      << "the first among equals";
}

TEST(TypingError, IsFoundOnlyInNamesThatAreNotSimilarOnPurpose) {
  using Pair = std::pair<const char*, const char*>;
  for (const auto& [a, b] : {Pair{"scna", "scan"}, Pair{"pre_chanel", "pre_channel"}, Pair{"/scan", "scan"},
                             Pair{"lidar_pionts", "lidar_points"}, Pair{"Scan", "scan"},
                             Pair{"lidarpoints", "lidar_points"}, Pair{"localisation", "localization"},
                             Pair{"front/camrea/image", "front/camera/image"}, Pair{"diagonstcis", "diagnostics"}}) {
    EXPECT_TRUE(DifferByATypingError(a, b)) << a << " and " << b;
    EXPECT_TRUE(DifferByATypingError(b, a)) << b << " and " << a;
  }
  for (const auto& [a, b] :
       {Pair{"image_raw", "image_rect"}, Pair{"wheel_speed_left", "wheel_speed_right"}, Pair{"cloud_in", "cloud_out"},
        Pair{"scan", "scan_f"}, Pair{"arm_l", "arm_r"}, Pair{"points", "joints"}, Pair{"camera1", "camera2"},
        Pair{"camera", "camera1"}, Pair{"camera/left/image", "camera/right/image"}, Pair{"map", "cap"},
        Pair{"scan", "scan"}, Pair{"a/b", "a_b"}, Pair{"", "scan"}, Pair{"velocity_x", "velocity_y"},
        Pair{"lidar_front", "lidar_rear"}, Pair{"transfroms_stautc", "transforms_static"}}) {
    EXPECT_FALSE(DifferByATypingError(a, b)) << a << " and " << b;
    EXPECT_FALSE(DifferByATypingError(b, a)) << b << " and " << a;
  }
}

// The distance that NearestName() uses, computed without its shortcuts.
std::size_t FullDistance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] = std::min({d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1), d[i][j - 1] + 1, d[i - 1][j] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

TEST(NearestName, IsTheOneThatAFullSearchFinds) {
  std::mt19937 random(20);
  const auto word = [&random] {
    std::string text(1 + random() % 9, 'a');
    for (char& c : text) c = static_cast<char>('a' + random() % 3);
    return text;
  };
  int found = 0;
  for (int round = 0; round < 3000; ++round) {
    const std::string name = word();
    std::vector<std::string> candidates(8);
    std::ranges::generate(candidates, word);
    std::string best;
    std::size_t least = std::max<std::size_t>(name.size() < 4 ? 1 : 2, name.size() / 3) + 1;
    for (const std::string& one : candidates) {
      const std::size_t distance = FullDistance(name, one);
      if (distance < least && distance < std::max(name.size(), one.size())) {
        least = distance;
        best = one;
      }
    }
    ASSERT_EQ(NearestName(name, candidates), best) << name;
    if (!best.empty()) ++found;
  }
  EXPECT_GT(found, 500);
}

TEST(NearestName, IsEmptyWhenNothingIsSimilar) {
  const std::vector<std::string> keys = {"publisher", "ip"};
  EXPECT_EQ(NearestName("xy", keys), "");
  EXPECT_EQ(NearestName("q", keys), "");
  EXPECT_EQ(NearestName("bandwidth", keys), "");
  EXPECT_EQ(NearestName("", keys), "");
  EXPECT_EQ(NearestName("ip", {}), "");
}

}  // namespace
}  // namespace hgros
