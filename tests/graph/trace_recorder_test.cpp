#include "hgros/graph/trace_recorder.hpp"

#include <gtest/gtest.h>

namespace hgros {
namespace {

class Recorder : public testing::Test {
 protected:
  Recorder() { recorder.SetOn(true); }
  void Publish(std::size_t times) {
    for (std::size_t i = 0; i < times; ++i) recorder.AddPublish("scan", "", info);
  }

  TraceRecorder recorder;
  MessageInfo info;
};

TEST_F(Recorder, CountsWhatIsTooMuch) {
  Publish(TraceRecorder::kMostEvents - 1);
  recorder.AddRun("scan", "mapper", info, 1, 2);
  Publish(3);
  recorder.AddRun("scan", "mapper", info, 3, 4);
  const TraceRecorder::Batch full = recorder.Take();
  EXPECT_EQ(full.publishes.size(), TraceRecorder::kMostEvents - 1);
  EXPECT_EQ(full.runs.size(), 1U);
  EXPECT_EQ(full.lost, 4U);
  Publish(1);
  const TraceRecorder::Batch next = recorder.Take();
  EXPECT_EQ(next.publishes.size(), 1U);
  EXPECT_EQ(next.lost, 0U);
}

TEST_F(Recorder, NamesAreOfTheirBatch) {
  recorder.AddPublish("scan", "driver", info);
  (void)recorder.Take();
  recorder.AddPublish("map", "mapper", info);
  const TraceRecorder::Batch batch = recorder.Take();
  ASSERT_EQ(batch.publishes.size(), 1U);
  EXPECT_EQ(batch.names.at(batch.publishes[0].channel), "map");
  EXPECT_EQ(batch.names.at(batch.publishes[0].node), "mapper");
}

TEST_F(Recorder, ForgetsWhenItIsTurnedOff) {
  Publish(2);
  recorder.SetOn(false);
  Publish(1);
  EXPECT_TRUE(recorder.Take().publishes.empty());
}

}  // namespace
}  // namespace hgros
