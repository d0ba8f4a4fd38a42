#include "terminal/units.hpp"

#include <gtest/gtest.h>

namespace hgros::cli {
namespace {

TEST(Units, ShowBoundsWithTheDigitsThatTellThemApart) {
  EXPECT_EQ(BoundText(100'100'000, 100'000, 101'000'000, Unit::kNanoseconds, false), "100.1 ms");
  EXPECT_EQ(BoundText(0, 200'000, 2'300'000, Unit::kNanoseconds, false), "0.0 ms");
  EXPECT_EQ(BoundText(40, 20, 900, Unit::kNanoseconds, false), "40 ns");
  EXPECT_EQ(BoundText(2'000'000, 1'000'000, 5'000'000, Unit::kBytes, false), "2 MB");
  EXPECT_EQ(BoundText(2'883, 0, 2'883, Unit::kBytes, false), "2.88 kB");
  EXPECT_EQ(BoundText(100'100'000, 100'000, 101'000'000, Unit::kNanoseconds, true), "100100000");
}

TEST(Units, ShowThreeDigits) {
  EXPECT_EQ(RateText(9.996, false), "10.0 Hz");
  EXPECT_EQ(RateText(1234.5, false), "1.23 kHz");
  EXPECT_EQ(BytesText(999, false), "999 B");
  EXPECT_EQ(BandwidthText(115'322, false), "115 kB/s");
  EXPECT_EQ(DurationText(-999, false), "-999 ns");
  EXPECT_EQ(DurationText(1'500'000'000, false), "1.50 s");
  EXPECT_EQ(DurationText(1'500, true), "1500");
}

}  // namespace
}  // namespace hgros::cli
