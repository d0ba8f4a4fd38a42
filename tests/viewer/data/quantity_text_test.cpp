#include "viewer/data/quantity_text.hpp"

#include <gtest/gtest.h>

namespace hgros::viewer {
namespace {

using namespace std::chrono_literals;

TEST(QuantityText, WritesThreeSignificantDigitsAndAUnit) {
  EXPECT_EQ(ByteRateText(0), "0 B/s");
  EXPECT_EQ(ByteRateText(340), "340 B/s");
  EXPECT_EQ(ByteRateText(1250), "1.25 kB/s");
  EXPECT_EQ(ByteRateText(40.25e6), "40.2 MB/s");
  EXPECT_EQ(ByteRateText(1.5e9), "1.50 GB/s");
  EXPECT_EQ(RateText(0), "0 Hz");
  EXPECT_EQ(RateText(0.05), "0.05 Hz");
  EXPECT_EQ(RateText(9.999), "10.0 Hz");
  EXPECT_EQ(RateText(1000), "1000 Hz");
}

TEST(QuantityText, ChoosesTheUnitOfADuration) {
  EXPECT_EQ(DurationText(340us), "340 us");
  EXPECT_EQ(DurationText(1250us), "1.25 ms");
  EXPECT_EQ(DurationText(12500ms), "12.5 s");
  EXPECT_EQ(DurationText(180s), "3 min");
  EXPECT_EQ(DurationText(-2ms), "-2.00 ms") << "the sender's clock may be ahead";
}

TEST(QuantityText, UsesSingularAndPlural) {
  EXPECT_EQ(Counted(1, "message", "messages"), "1 message");
  EXPECT_EQ(Counted(0, "message", "messages"), "0 messages");
  EXPECT_EQ(Counted(12, "entity", "entities"), "12 entities");
}

}  // namespace
}  // namespace hgros::viewer
