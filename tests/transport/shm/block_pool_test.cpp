#include "transport/shm/memory/block_pool.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <random>
#include <thread>
#include <vector>

#include "support/seed.hpp"
#include "transport/shm/memory/layout.hpp"

namespace hgros::shm {
namespace {

constexpr std::uint64_t kMega = 1u << 20;

std::shared_ptr<BlockPool> Pool(std::uint64_t limit_bytes) { return std::make_shared<BlockPool>(limit_bytes); }

struct Taken {
  BlockPool::Loan loan;
  unsigned char mark = 0;
};

bool Holds(const Taken& taken) {
  const auto bytes = taken.loan.bytes;
  const auto mark = static_cast<std::byte>(taken.mark);
  return bytes.empty() || (bytes.front() == mark && bytes[bytes.size() / 2] == mark && bytes.back() == mark);
}

void Mark(Taken& taken) {
  const auto bytes = taken.loan.bytes;
  if (bytes.empty()) return;
  bytes.front() = bytes[bytes.size() / 2] = bytes.back() = static_cast<std::byte>(taken.mark);
}

/// Compares with a model: a block that was taken and not returned keeps its bytes, is at its stated place, and
/// overlaps no other block.
void AgainstAModel(int seed, std::uint64_t limit_bytes, std::size_t largest) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::minstd_rand random(static_cast<unsigned>(seed));
  const auto pool = Pool(limit_bytes);
  std::vector<Taken> model;
  std::map<std::uint32_t, bool> gone;
  for (int step = 0; step < 1500; ++step) {
    if (random() % 5 < 3) {
      const std::size_t size = random() % 8 == 0 ? random() % (largest + 1) : random() % 3000;
      std::string fault;
      auto loan = pool->Allocate(size, &fault);
      if (!loan) {
        ASSERT_FALSE(fault.empty());
        // Refused only if blocks in use, or this block alone, exceed the limit.
        std::uint64_t in_use = 0;
        for (const Taken& one : model) in_use += BlockPool::BlockBytes(one.loan.bytes.size());
        ASSERT_TRUE(in_use > 0 || BlockPool::BlockBytes(size) > limit_bytes) << size;
        continue;
      }
      ASSERT_EQ(loan->bytes.size(), size);
      ASSERT_FALSE(gone.contains(loan->place.segment));
      const auto place = pool->Find(loan->bytes);
      if (size > 0) {
        ASSERT_TRUE(place && place->segment == loan->place.segment && place->offset_bytes == loan->place.offset_bytes);
      }
      for (const Taken& one : model) {
        ASSERT_TRUE(loan->bytes.data() + size <= one.loan.bytes.data() ||
                    one.loan.bytes.data() + one.loan.bytes.size() <= loan->bytes.data());
      }
      model.push_back({std::move(*loan), static_cast<unsigned char>(random())});
      Mark(model.back());
    } else if (!model.empty()) {
      std::swap(model[random() % model.size()], model.back());
      ASSERT_TRUE(Holds(model.back()));
      model.pop_back();
    }
    if (random() % 16 == 0) {
      for (const std::uint32_t segment : pool->CollectRemovedSegments()) {
        ASSERT_TRUE(gone.emplace(segment, true).second) << "returned twice";
        ASSERT_EQ(pool->HandleOf(segment), nullptr);
      }
    }
    const auto usage = pool->usage();
    ASSERT_EQ(usage.blocks_in_use, model.size());
    ASSERT_LE(usage.segment_bytes, limit_bytes);
    ASSERT_LE(usage.segments, kMaxSegments);
  }
  for (const Taken& one : model) ASSERT_TRUE(Holds(one));
  model.clear();
  EXPECT_EQ(pool->usage().blocks_in_use, 0u);
}

TEST(ShmBlockPool, AgreesWithANaiveModel) {
  for (int seed = 1; seed <= test::Rounds(2, 6); ++seed) {
    AgainstAModel(seed, 64 * kMega, 8 * kMega);
    AgainstAModel(seed, 2 * kMega, kMega);
  }
}

TEST(ShmBlockPool, FreesSegmentsOfOtherSizesBeforeItRefuses) {
  const auto pool = Pool(4 * kMega);
  std::vector<BlockPool::Loan> small;
  while (auto loan = pool->Allocate(1000)) small.push_back(std::move(*loan));
  EXPECT_GE(small.size(), 4000u);
  std::string fault;
  EXPECT_FALSE(pool->Allocate(3 * kMega, &fault));
  EXPECT_EQ(fault, "all 4 MB of shared memory are in use");
  small.clear();
  EXPECT_TRUE(pool->Allocate(3 * kMega));
  EXPECT_FALSE(pool->CollectRemovedSegments().empty());
}

TEST(ShmBlockPool, ManyBlocksNeedFewSegments) {
  const auto pool = Pool(64 * kMega);
  std::vector<BlockPool::Loan> held;
  for (int i = 0; i < 8000; ++i) held.push_back(pool->Allocate(4000).value());
  EXPECT_LT(pool->usage().segments, 20u);
}

TEST(ShmBlockPool, RefusesImpossibleSizes) {
  const auto pool = Pool(~std::uint64_t{0});
  EXPECT_FALSE(pool->Allocate(~std::size_t{0}));
  EXPECT_FALSE(pool->Allocate(~std::size_t{0} / 2));
  EXPECT_TRUE(pool->Allocate(0));
  EXPECT_FALSE(Pool(0)->Allocate(1));
}

TEST(ShmBlockPool, AllocatesNothingAfterClose) {
  const auto pool = Pool(kMega);
  auto loan = pool->Allocate(100);
  ASSERT_TRUE(loan);
  loan.reset();  // A receiver may still read it.
  pool->Close();
  std::string fault;
  EXPECT_FALSE(pool->Allocate(100, &fault));
  EXPECT_EQ(fault, "the session has ended");
}

TEST(ShmBlockPool, AForkedChildNeitherAllocatesNorFrees) {
  const auto pool = Pool(kMega);
  auto held = pool->Allocate(100);
  const pid_t child = fork();
  if (child == 0) {
    const bool taken = pool->Allocate(100).has_value();
    held.reset();
    _exit(taken || pool->usage().blocks_in_use != 1 ? 1 : 0);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

TEST(ShmBlockPool, BlocksOutliveThePoolAndEndOnAnyThread) {
  auto pool = Pool(16 * kMega);
  std::vector<std::jthread> threads;
  for (unsigned seed = 0; seed < 4; ++seed) {
    threads.emplace_back([seed, pool] {
      std::minstd_rand random(seed + 1);
      std::vector<Taken> mine;
      for (int i = 0; i < 3000; ++i) {
        if (mine.size() > 20) mine.erase(mine.begin() + static_cast<std::ptrdiff_t>(random() % mine.size()));
        auto loan = pool->Allocate(random() % 20'000);
        if (!loan) continue;
        mine.push_back({std::move(*loan), static_cast<unsigned char>(random())});
        Mark(mine.back());
        ASSERT_TRUE(std::ranges::all_of(mine, Holds));
      }
    });
  }
  pool.reset();
}

TEST(ShmBlockPool, AllocatesNothingBeyondTheRoomThatTheSystemReports) {
  std::uint64_t room = 10 * kMega;
  const auto pool = std::make_shared<BlockPool>(1000 * kMega, [&room] { return std::optional(room); });
  std::vector<BlockPool::Loan> taken;
  std::string fault;
  for (;;) {
    const std::uint64_t before = pool->usage().segment_bytes;
    auto loan = pool->Allocate(kMega, &fault);
    if (!loan) break;
    taken.push_back(std::move(*loan));
    room -= pool->usage().segment_bytes - before;
  }
  EXPECT_EQ(taken.size(), 6u) << "the rest of the room stays free for messages over the socket";
  EXPECT_EQ(fault, "the memory limit of its control group leaves too little");
  room = 5 * kMega;
  EXPECT_TRUE(pool->Allocate(kMega));
}

TEST(ShmBlockPool, RemovedSegmentsCountAsFreeOnlyWhenTheSystemReportsRoom) {
  std::uint64_t room = 100 * kMega;
  const auto pool = std::make_shared<BlockPool>(1000 * kMega, [&room] { return std::optional(room); });
  ASSERT_TRUE(pool->Allocate(3 * kMega));  // Returned at once.
  room = 0;
  EXPECT_FALSE(pool->Allocate(2 * kMega)) << "receivers may still use it";
  EXPECT_EQ(pool->usage().segments, 0u);
  room = 100 * kMega;
  EXPECT_TRUE(pool->Allocate(2 * kMega));
}

}  // namespace
}  // namespace hgros::shm
