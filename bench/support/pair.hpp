#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hgros/codec/block.hpp"
#include "support/samples.hpp"

namespace hgros::bench {

/// Memory that the two processes of a measurement share through a file. It carries no payload.
struct PairControl {
  static constexpr std::size_t kSlots = 4096;
  std::atomic<std::uint32_t> receiver_ready{0};
  std::atomic<std::uint32_t> stop{0};
  std::atomic<std::uint64_t> received{0};
  std::atomic<std::int64_t> last_arrival_ns{0};
  std::array<std::atomic<std::int64_t>, kSlots> latency_ns{};
};
/// Path of a new file in memory, which other processes can open while this one lives. It leaves nothing behind.
std::string MemoryFile();

/// Opens the file, which may be new. Exits with an error message if that fails.
PairControl* OpenControl(const std::string& path);

/// The first bytes of every message.
struct Stamp {
  std::int64_t sent_ns;
  std::uint64_t index;
};

/// A receiver calls it for every message. It records the time of arrival.
void NoteArrival(PairControl& control, Bytes bytes);

/// One way to send bytes to the other process: ours or a floor.
class PairSender {
 public:
  virtual ~PairSender() = default;
  /// Sends without copying if the transport can. The block must not change before it has arrived.
  virtual void Send(const std::shared_ptr<Block>& block) = 0;
};
/// The other end of a PairSender. Calls NoteArrival until destroyed.
class PairReceiver {
 public:
  virtual ~PairReceiver() = default;
};

/// Blocks that are allocated and filled before the measurement.
class BlockPool {
 public:
  BlockPool(std::size_t size_bytes, std::size_t count);
  /// The next block with `index` and the current time in its first bytes.
  const std::shared_ptr<Block>& Stamped(std::uint64_t index);

 private:
  std::vector<std::shared_ptr<Block>> blocks_;
  std::size_t next_ = 0;
};

/// One-way latencies of `count` messages sent `pause_us` apart, ns. Messages lost after 2 s are left out.
Samples MeasurePair(PairControl& control, PairSender& sender, BlockPool& pool, int count, int pause_us);
/// Messages per second, flooded, until all `count` have arrived. If nothing arrives for 2 s, counts those that came.
double FloodPair(PairControl& control, PairSender& sender, BlockPool& pool, int count);

/// "1KB" ... "4MB".
std::string SizeName(std::size_t size_bytes);
inline constexpr std::array<std::size_t, 7> kSizes{1024,       4096,        16 * 1024,  64 * 1024,
                                                   256 * 1024, 1024 * 1024, 4096 * 1024};

// The transports. `endpoint` is in ZeroMQ's form; for raw TCP it is "host:port"; for raw shared memory a path; for ours
// through shared memory "domain:" and the domain in which the two sessions find each other.
std::unique_ptr<PairSender> MakeZmqSender(const std::string& endpoint);
std::unique_ptr<PairReceiver> MakeZmqReceiver(const std::string& endpoint, PairControl& control);
std::unique_ptr<PairSender> MakeTcpSender(const std::string& endpoint);
std::unique_ptr<PairReceiver> MakeTcpReceiver(const std::string& endpoint, PairControl& control);
std::unique_ptr<PairSender> MakeShmSender(const std::string& path);
std::unique_ptr<PairReceiver> MakeShmReceiver(const std::string& path, PairControl& control);
/// Ours with the bytes as the data of a foxglove::PointCloud, on the inline executor.
std::unique_ptr<PairSender> MakeOurPlainSender(const std::string& endpoint);
std::unique_ptr<PairReceiver> MakeOurPlainReceiver(const std::string& endpoint, PairControl& control);
/// Likewise as a Bulk<foxglove::PointCloud>, lent for each message.
std::unique_ptr<PairSender> MakeOurBulkSender(const std::string& endpoint);
std::unique_ptr<PairReceiver> MakeOurBulkReceiver(const std::string& endpoint, PairControl& control);
/// `executor`: inline or tbb.
std::unique_ptr<PairSender> MakeOurSender(const std::string& endpoint, bool lossless);
std::unique_ptr<PairReceiver> MakeOurReceiver(const std::string& endpoint, PairControl& control,
                                              const std::string& executor, bool lossless);

}  // namespace hgros::bench
