#include "hgros/yaml/scalar_text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace hgros::scalar {
namespace {

TEST(FromNumber, WritesNumbersAsPeopleDo) {
  EXPECT_EQ(FromNumber(0.0), "0.0");
  EXPECT_EQ(FromNumber(-2.5), "-2.5");
  EXPECT_EQ(FromNumber(300000.0), "300000.0");
  EXPECT_EQ(FromNumber(0.0005), "0.0005");
  EXPECT_EQ(FromNumber(1e15), "1000000000000000.0");
  EXPECT_EQ(FromNumber(1e20), "1e+20");
  EXPECT_EQ(FromNumber(-1.5e-7), "-1.5e-07");
  EXPECT_EQ(FromNumber(INFINITY), ".inf");
  EXPECT_EQ(FromNumber(-INFINITY), "-.inf");
  EXPECT_EQ(FromNumber(NAN), ".nan");
}

TEST(FromNumber, IsReadAsTheSameNumber) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> exponent(-310, 308);
  std::uniform_real_distribution<double> digits(-10, 10);
  for (int i = 0; i < 10'000; ++i) {
    const double number = digits(random) * std::pow(10.0, exponent(random) - 1);
    EXPECT_EQ(Number(FromNumber(number)), number);
  }
  for (const double number :
       {std::numeric_limits<double>::max(), std::numeric_limits<double>::denorm_min(), 1e16, 1e-4}) {
    EXPECT_EQ(Number(FromNumber(number)), number);
  }
}

}  // namespace
}  // namespace hgros::scalar
