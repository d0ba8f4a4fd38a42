// One participant of a resilience test. It publishes numbered, checksummed messages, receives and checks them, or
// both, and writes its counters to standard output every 20 ms: "status name=number ...", and the lines of the
// session's log: "log ...". It ends in order on SIGTERM, and is killed when its parent ends.
//
//   --config=YAML        of the session
//   --group=FOLDER       enter this memory control group
//   --out=CHANNEL        publish there: --count=N messages (0: without end) of --size=BYTES, one every --period-us=N,
//                        after --await=N subscribers have come; waits for room where there is none; --bulk=1: as
//                        Bulk; --spare-mb=N: then the process may allocate only this much more
//   --in=CHANNEL         subscribe there: --keep-all=N or --keep-last=N, with a callback that takes --slow-ms=N
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>

#include <foxglove/RawImage.pb.h>

#include "hgros/hgros.hpp"
#include "resilience/worker_program.hpp"
#include "support/await.hpp"

namespace hgros::resilience {
namespace {

using Image = foxglove::RawImage;

constexpr auto kRoomPatience = std::chrono::seconds(60);
constexpr auto kReportPeriod = std::chrono::milliseconds(20);

/// The begin of each message's data. The rest is computed from the sequence.
struct Stamp {
  std::uint64_t publisher = 0;  ///< The id of its process.
  std::uint64_t sequence = 0;   ///< Counts from 1.
  std::uint64_t checksum = 0;   ///< Checksum of the data, computed with 0 in this field.
};

void Fill(std::span<char> data, std::uint64_t sequence) {
  std::uint64_t word = sequence;
  for (std::size_t i = sizeof(Stamp); i + sizeof word <= data.size(); i += sizeof word) {
    word = word * 6364136223846793005ULL + 1442695040888963407ULL;
    std::memcpy(data.data() + i, &word, sizeof word);
  }
  Stamp stamp{static_cast<std::uint64_t>(getpid()), sequence, 0};
  std::memcpy(data.data(), &stamp, sizeof stamp);
  stamp.checksum = std::hash<std::string_view>{}({data.data(), data.size()});
  std::memcpy(data.data(), &stamp, sizeof stamp);
}

std::unique_ptr<Image> MakeImage(std::uint64_t sequence, std::size_t size_bytes) {
  auto image = std::make_unique<Image>();
  image->mutable_data()->resize(std::max(size_bytes, sizeof(Stamp)));
  Fill(*image->mutable_data(), sequence);
  return image;
}

std::unique_ptr<Bulk<Image>> MakeBulk(std::uint64_t sequence, std::size_t size_bytes) {
  auto image = std::make_unique<Bulk<Image>>(std::max(size_bytes, sizeof(Stamp)));
  Fill({reinterpret_cast<char*>(image->writable().data()), image->writable().size()}, sequence);
  return image;
}

/// From now on this process may allocate only this much more.
void LimitMemory(std::uint64_t spare_bytes) {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlimit limit{pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) + spare_bytes, RLIM_INFINITY};
  setrlimit(RLIMIT_AS, &limit);
}

/// All zero if the data are not those that were published.
Stamp ReadStamp(const Image& image) {
  std::string data = image.data();
  Stamp stamp;
  if (data.size() < sizeof stamp) return {};
  std::memcpy(&stamp, data.data(), sizeof stamp);
  std::memset(data.data() + offsetof(Stamp, checksum), 0, sizeof stamp.checksum);
  return std::hash<std::string>{}(data) == stamp.checksum ? stamp : Stamp{};
}

/// Publishes on a thread of its own.
class Source {
 public:
  Source(Session& session, const Arguments& arguments)
      : session_(session),
        channel_(arguments.Text("out")),
        publish_(session.Advertise<Image>(channel_)),
        publish_bulk_(session.Advertise<Bulk<Image>>(channel_)),
        thread_([this, arguments](const std::stop_token& stop) { Run(stop, arguments); }) {}

  void Report(std::string& line) const {
    line += " published=" + std::to_string(published_) + " full=" + std::to_string(full_) +
            " waiting=" + std::to_string(waiting_) + " refused=" + std::to_string(refused_) +
            " no_memory=" + std::to_string(no_memory_);
  }

 private:
  void Run(const std::stop_token& stop, const Arguments& arguments) {
    const bool bulk = arguments.Number("bulk") > 0;
    const std::uint64_t count = arguments.Number("count");
    const std::size_t size_bytes = arguments.Number("size", 64);
    const std::chrono::microseconds period(arguments.Number("period-us", 1000));
    if (!session_.WaitForSubscribers(channel_, arguments.Number("await"), test::kPatience)) return;
    if (const auto spare_mb = arguments.Number("spare-mb"); spare_mb > 0) LimitMemory(spare_mb << 20);
    auto next = std::chrono::steady_clock::now();
    for (std::uint64_t sequence = 1; (count == 0 || sequence <= count) && !stop.stop_requested(); ++sequence) {
      PublishStatus status = PublishStatus::kEmpty;
      try {
        status = bulk ? Publish(publish_bulk_, MakeBulk(sequence, size_bytes), stop)
                      : Publish(publish_, MakeImage(sequence, size_bytes), stop);
      } catch (const std::bad_alloc&) {  // The earlier messages have not ended yet.
        --sequence;
      }
      if (status == PublishStatus::kOk) {
        ++published_;
      } else if (status != PublishStatus::kEmpty) {
        ++refused_;
        no_memory_ += status == PublishStatus::kNoMemory ? 1 : 0;
      }
      next = std::max(next + period, std::chrono::steady_clock::now() - period);
      std::unique_lock lock(mutex_);
      stopped_.wait_until(lock, stop, next, [] { return false; });
    }
  }

  template <class Message>
  PublishStatus Publish(const Publisher<Message>& publish, std::unique_ptr<Message> image,
                        const std::stop_token& stop) {
    PublishStatus status = publish(std::move(image));
    if (status != PublishStatus::kFull) return status;
    ++full_;
    waiting_ = 1;
    status = publish.Wait(std::move(image), std::chrono::steady_clock::now() + kRoomPatience, stop);
    waiting_ = 0;
    return status;
  }

  Session& session_;
  const std::string channel_;
  const Publisher<Image> publish_;
  const Publisher<Bulk<Image>> publish_bulk_;
  std::atomic<std::uint64_t> published_{0};
  std::atomic<std::uint64_t> full_{0};
  std::atomic<std::uint64_t> refused_{0};
  std::atomic<std::uint64_t> no_memory_{0};
  std::atomic<int> waiting_{0};
  std::mutex mutex_;
  std::condition_variable_any stopped_;
  std::jthread thread_;
};

/// Receives and checks messages. A publisher with another process id begins a new count.
class Sink {
 public:
  Sink(Session& session, const Arguments& arguments) : slow_(arguments.Number("slow-ms")) {
    NodeOptions options;
    options.queue = Queue::KeepLast(arguments.Number("keep-last", 64));
    if (const auto depth = arguments.Number("keep-all"); depth > 0) options.queue = Queue::KeepAll(depth);
    options.executor = Executor::Dedicated();
    subscription_ = session.FromAny<Image>(
        arguments.Text("in"), Invoke::kSerial, [this](const Image& image) { Take(image); }, options);
  }

  void Report(std::string& line) const {
    const auto node = subscription_.stats();
    const std::scoped_lock lock(mutex_);
    line += " received=" + std::to_string(received_) + " from=" + std::to_string(from_) +
            " first=" + std::to_string(first_) + " last=" + std::to_string(last_) + " gaps=" + std::to_string(gaps_) +
            " disorder=" + std::to_string(disorder_) + " corrupt=" + std::to_string(corrupt_) +
            " pushed_out=" + std::to_string(node.dropped);
  }

 private:
  void Take(const Image& image) {
    const Stamp stamp = ReadStamp(image);
    {
      const std::scoped_lock lock(mutex_);
      ++received_;
      if (stamp.sequence == 0) {
        ++corrupt_;
      } else if (stamp.publisher != from_) {
        from_ = stamp.publisher;
        first_ = last_ = stamp.sequence;
      } else if (stamp.sequence > last_) {
        gaps_ += stamp.sequence - last_ - 1;
        last_ = stamp.sequence;
      } else {
        ++disorder_;
      }
    }
    if (slow_.count() > 0) (void)test::Await([] { return false; }, slow_);
  }

  const std::chrono::milliseconds slow_;
  mutable std::mutex mutex_;
  std::uint64_t received_ = 0;
  std::uint64_t from_ = 0;
  std::uint64_t first_ = 0;
  std::uint64_t last_ = 0;
  std::uint64_t gaps_ = 0;
  std::uint64_t disorder_ = 0;  // Includes repeats.
  std::uint64_t corrupt_ = 0;
  Subscription subscription_;
};

void ReportSession(const Session& session, std::string& line) {
  const SessionSnapshot snapshot = session.Snapshot();
  OutboundStats out;
  PublisherTraffic in;
  std::uint64_t faults = 0;
  std::size_t publishers = 0;
  LogHistogram transport;
  for (const ChannelTraffic& traffic : snapshot.traffic) {
    out.subscribers += traffic.out.subscribers;
    out.dropped += traffic.out.dropped;
    out.missed += traffic.out.missed;
    out.queued_bytes += traffic.out.queued_bytes;
    publishers += traffic.publishers;
    for (const PublisherTraffic& one : traffic.in) {
      in.received += one.received;
      in.lost += one.lost;
      in.repeated += one.repeated;
    }
    for (const std::uint64_t count : traffic.faults) faults += count;
    transport.Merge(traffic.transport);
  }
  for (const std::uint64_t count : snapshot.transport.faults) faults += count;
  line += " subscribers=" + std::to_string(out.subscribers) + " dropped=" + std::to_string(out.dropped) +
          " missed=" + std::to_string(out.missed) + " queued_bytes=" + std::to_string(out.queued_bytes) +
          " publishers=" + std::to_string(publishers) + " came=" + std::to_string(in.received) +
          " lost=" + std::to_string(in.lost) + " repeated=" + std::to_string(in.repeated) +
          " faults=" + std::to_string(faults) + " peers=" + std::to_string(snapshot.peers.size()) +
          " delay_ns=" + std::to_string(transport.Quantile(0.5));
}

int Run(const Arguments& arguments, const sigset_t& end) {
  if (const std::string group = arguments.Text("group"); !group.empty()) {
    if (!(std::ofstream(group + "/cgroup.procs") << getpid() << std::flush)) return 3;
  }
  Session session(Config::Parse(arguments.Text("config")),
                  SessionOptions{"worker", [](LogLevel, std::string_view text) { Say("log " + std::string(text)); }});
  std::optional<Sink> sink;
  std::optional<Source> source;
  if (!arguments.Text("in").empty()) sink.emplace(session, arguments);
  if (!arguments.Text("out").empty()) source.emplace(session, arguments);
  const timespec period{0, std::chrono::nanoseconds(kReportPeriod).count()};
  int signal = 0;
  do {
    std::string line = "status ready=1";
    // The network's counters are read first, then those of the callbacks. So the latter are never behind in the
    // report.
    ReportSession(session, line);
    if (source) source->Report(line);
    if (sink) sink->Report(line);
    Say(line);
    signal = sigtimedwait(&end, nullptr, &period);
  } while (signal < 0);
  return 0;
}

}  // namespace
}  // namespace hgros::resilience

int main(int count, char** texts) { return hgros::resilience::RunWorker(count, texts, hgros::resilience::Run); }
