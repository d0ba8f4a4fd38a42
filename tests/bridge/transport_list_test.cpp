#include "hgros/bridge/transport_list.hpp"

#include <gtest/gtest.h>

#include "hgros/base/error.hpp"

namespace hgros {
namespace {

TransportEntry Named(const std::string& key, int cost, TransportReach reach = TransportReach::kNetwork) {
  return {key, "the " + key, cost, reach, {}, true};
}

TEST(ListOfTransports, HasTheCheapestFirst) {
  const TransportList list({Named("far", 3), Named("near", 1, TransportReach::kHost), Named("between", 2)});
  EXPECT_EQ(list.Find("near"), 0U);
  EXPECT_EQ(list.Find("between"), 1U);
  EXPECT_EQ(list.Find("far"), 2U);
  EXPECT_EQ(list.Find("elsewhere"), std::nullopt);
  EXPECT_EQ(list.on_host(), TransportSet{0});
  EXPECT_EQ(list.NamesOf({0, 2}), "the near and the far");
}

TEST(ListOfTransports, TurnsKeysIntoSets) {
  const TransportList list({Named("a", 1), Named("b", 2)});
  EXPECT_EQ(list.SetOf(std::nullopt), list.all());
  EXPECT_EQ(list.SetOf(std::vector<std::string>{"b", "unknown"}), TransportSet{1});
  EXPECT_TRUE(list.SetOf(std::vector<std::string>{"unknown"}).empty());
}

TEST(ListOfTransports, RefusesTwoWithOneKey) { EXPECT_THROW(TransportList({Named("a", 1), Named("a", 2)}), Error); }

TEST(SetOfTransports, ReturnsItsCheapest) {
  const TransportSet set{1, 4};
  EXPECT_EQ(set.cheapest(), 1U);
  EXPECT_EQ(set.CheaperThan(4), TransportSet{1});
  EXPECT_TRUE(set.CheaperThan(1).empty());
  EXPECT_EQ(set.Without(TransportSet{1}).cheapest(), 4U);
  EXPECT_EQ(TransportSet().cheapest(), std::nullopt);
}

}  // namespace
}  // namespace hgros
