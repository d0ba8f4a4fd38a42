// Cyclone DDS, reliable. Octets over UDP on loopback (udp) or within one participant (local), keep-all. Octets and lent
// samples through iceoryx (shm, loan), keep-last 16, because keep-all switches shared memory off. The runner chooses
// the transport through CYCLONEDDS_URI. The last two need iox-roudi.
#include <cyclone.h>
#include <dds/dds.h>
#include <dds/ddsc/dds_loan_api.h>

#include <algorithm>
#include <thread>

#include "buffers.hpp"
#include "peer.hpp"

namespace hgros::bench {
namespace {

constexpr std::size_t kKeepLast = 16;

const dds_topic_descriptor_t* LentType(std::size_t size_bytes) {
  switch (size_bytes) {
    case 1024: return &hgros_bench_P1024_desc;
    case 4096: return &hgros_bench_P4096_desc;
    case 16384: return &hgros_bench_P16384_desc;
    case 65536: return &hgros_bench_P65536_desc;
    case 262144: return &hgros_bench_P262144_desc;
    case 1048576: return &hgros_bench_P1048576_desc;
    case 4194304: return &hgros_bench_P4194304_desc;
    default: Fail("Cyclone DDS has no type of " + std::to_string(size_bytes) + " bytes to lend");
  }
}

dds_entity_t Made(dds_entity_t entity, const char* what) {
  if (entity < 0) Fail(std::string("Cyclone DDS cannot create a ") + what + ": " + dds_strretcode(-entity));
  return entity;
}

/// How a mode carries messages.
struct Way {
  bool shm;
  bool lent;
};

/// A lane's topic and the settings of its two ends.
class Topic {
 public:
  Topic(dds_entity_t participant, const Lane& lane, Way way) : way_(way), qos_(dds_create_qos()) {
    const auto depth = static_cast<std::int32_t>(lane.depth());
    dds_qset_reliability(qos_, DDS_RELIABILITY_RELIABLE, DDS_SECS(5));
    if (way.shm) {
      dds_qset_history(qos_, DDS_HISTORY_KEEP_LAST, std::min<std::int32_t>(depth, kKeepLast));
    } else {
      dds_qset_history(qos_, DDS_HISTORY_KEEP_ALL, 0);
    }
    dds_qset_resource_limits(qos_, depth, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
    const dds_topic_descriptor_t* type = way.lent ? LentType(lane.size_bytes) : &hgros_bench_Octets_desc;
    topic_ = Made(dds_create_topic(participant, type, lane.name.c_str(), qos_, nullptr), "topic");
  }
  Topic(const Topic&) = delete;
  Topic& operator=(const Topic&) = delete;
  ~Topic() {
    dds_delete(topic_);
    dds_delete_qos(qos_);
  }
  dds_entity_t Reader(dds_entity_t participant, const dds_listener_t* listener) const {
    return Checked(Made(dds_create_reader(participant, topic_, qos_, listener), "reader"));
  }
  dds_entity_t Writer(dds_entity_t participant) const {
    return Checked(Made(dds_create_writer(participant, topic_, qos_, nullptr), "writer"));
  }
  [[nodiscard]] Way way() const { return way_; }

 private:
  [[nodiscard]] dds_entity_t Checked(dds_entity_t end) const {
    if (way_.shm && !dds_is_shared_memory_available(end)) Fail("Cyclone DDS cannot use shared memory here");
    return end;
  }
  Way way_;
  dds_qos_t* qos_;
  dds_entity_t topic_;
};

class CycloneInlet final : public Inlet {
 public:
  CycloneInlet(dds_entity_t participant, const Lane& lane, Way way, Sink& sink)
      : topic_(participant, lane, way), size_bytes_(lane.size_bytes), sink_(sink) {
    dds_listener_t* listener = dds_create_listener(this);
    dds_lset_data_available(listener,
                            [](dds_entity_t reader, void* self) { static_cast<CycloneInlet*>(self)->TakeAll(reader); });
    reader_ = topic_.Reader(participant, listener);
    dds_delete_listener(listener);
  }
  ~CycloneInlet() override { dds_delete(reader_); }

 private:
  void TakeAll(dds_entity_t reader) {
    for (;;) {
      void* sample = nullptr;
      dds_sample_info_t info{};
      const dds_return_t count = dds_take(reader, &sample, &info, 1, 1);
      if (count <= 0) return;
      if (info.valid_data && topic_.way().lent) sink_.Note(sample, size_bytes_);
      if (info.valid_data && !topic_.way().lent) {
        const auto& octets = static_cast<const hgros_bench_Octets*>(sample)->data;
        sink_.Note(octets._buffer, octets._length);
      }
      dds_return_loan(reader, &sample, count);
    }
  }
  Topic topic_;
  std::size_t size_bytes_;
  Sink& sink_;
  dds_entity_t reader_ = 0;
};

class CycloneOutlet final : public Outlet {
 public:
  CycloneOutlet(dds_entity_t participant, const Lane& lane, Way way)
      : topic_(participant, lane, way), writer_(topic_.Writer(participant)), bytes_(FilledBuffer(lane.size_bytes)) {
    if (way.lent && !dds_is_loan_available(writer_)) Fail("Cyclone DDS cannot lend samples here");
    octets_.data._buffer = reinterpret_cast<std::uint8_t*>(bytes_.data());
    octets_.data._length = octets_.data._maximum = static_cast<std::uint32_t>(bytes_.size());
  }
  ~CycloneOutlet() override { dds_delete(writer_); }
  std::byte* Take() override {
    if (!matched_) {
      dds_publication_matched_status_t status{};
      matched_ = dds_get_publication_matched_status(writer_, &status) == DDS_RETCODE_OK && status.current_count > 0;
      if (!matched_) return nullptr;
    }
    if (!topic_.way().lent) return bytes_.data();
    if (dds_loan_sample(writer_, &lent_) == DDS_RETCODE_OK) return static_cast<std::byte*>(lent_);
    std::this_thread::yield();
    return nullptr;
  }
  bool Publish() override { return dds_write(writer_, topic_.way().lent ? lent_ : &octets_) == DDS_RETCODE_OK; }
  [[nodiscard]] bool lends() const override { return topic_.way().lent; }

 private:
  Topic topic_;
  dds_entity_t writer_;
  std::vector<std::byte> bytes_;
  hgros_bench_Octets octets_{};
  void* lent_ = nullptr;
  bool matched_ = false;
};

class Cyclone final : public Peer {
 public:
  explicit Cyclone(Way way)
      : way_(way), participant_(Made(dds_create_participant(DDS_DOMAIN_DEFAULT, nullptr, nullptr), "participant")) {}
  ~Cyclone() override { dds_delete(participant_); }
  std::unique_ptr<Inlet> Subscribe(const Lane& lane, Sink& sink) override {
    return std::make_unique<CycloneInlet>(participant_, lane, way_, sink);
  }
  std::unique_ptr<Outlet> Publish(const Lane& lane) override {
    return std::make_unique<CycloneOutlet>(participant_, lane, way_);
  }

 private:
  Way way_;
  dds_entity_t participant_;
};

}  // namespace

std::unique_ptr<Peer> MakePeer(const Task& task) {
  if (task.mode == "udp" || task.mode == "local") return std::make_unique<Cyclone>(Way{false, false});
  if (task.mode == "shm") return std::make_unique<Cyclone>(Way{true, false});
  if (task.mode == "loan") return std::make_unique<Cyclone>(Way{true, true});
  Fail("Cyclone DDS has no mode \"" + task.mode + "\"");
}

}  // namespace hgros::bench
