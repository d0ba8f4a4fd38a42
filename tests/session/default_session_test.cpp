// The free functions, as the listings of the paper use them.
#include "hgros/session/default_session.hpp"

#include <gtest/gtest.h>

#include "hgros/base/error.hpp"
#include "session/session_fixture.hpp"

namespace hgros {
namespace {

using test::Await;
using test::Note;
using test::Notes;

TEST(DefaultSession, PublishesAndSubscribesThroughFreeFunctions) {
  Init();
  Notes any;
  Notes graph;
  FromAny<Note>("any", Invoke::kSerial, std::ref(any));
  FromGraph<Note>("graph", Invoke::kConcurrent, std::ref(graph));
  EXPECT_EQ(ToAny("any", std::make_unique<Note>("a")), PublishStatus::kOk);
  EXPECT_EQ(ToAny("any", Note("b")), PublishStatus::kOk);
  EXPECT_EQ(ToGraph("graph", std::make_shared<const Note>("c")), PublishStatus::kOk);
  EXPECT_TRUE(Await([&] { return any.size() == 2 && graph.size() == 1; }));
  Shutdown();
}

TEST(DefaultSession, MisuseThrowsAnErrorThatNamesTheFix) {
  EXPECT_THROW((void)DefaultSession(), Error);
  Init();
  EXPECT_THROW(Init(), Error);
  Shutdown();
  EXPECT_THROW((void)ToAny("c", Note("x")), Error);
  Shutdown();  // A second call is allowed.
}

}  // namespace
}  // namespace hgros
