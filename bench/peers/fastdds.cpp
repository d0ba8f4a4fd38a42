// Fast DDS, reliable and keep-all. Octets over the default transports with UDP limited to one interface (shm_udp); over
// shared memory with a segment for 8 messages and no fragments (shm_tuned); over UDP alone (udp), with settings for
// large messages on a slow line (udp_tuned). Also plain samples that both sides lend through data sharing (loan).
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include <fastdds/dds/core/LoanableSequence.hpp>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include "buffers.hpp"
#include "fastdds_types.hpp"
#include "peer.hpp"

namespace hgros::bench {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using Code = eprosima::fastrtps::types::ReturnCode_t;

constexpr std::size_t kLargestUnfragmented = 60'000;
constexpr std::int32_t kSparseDepth = 64;
constexpr std::uint32_t kReceiveBufferBytes = 4u << 20;  // Larger messages overflow the system's 208 KB.

/// The settings of both sides.
template <class Qos>
void SetQos(Qos& qos, const Lane& lane, bool loan) {
  const auto depth = static_cast<std::int32_t>(lane.depth());
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.reliability().max_blocking_time = eprosima::fastrtps::Duration_t(5, 0);
  qos.history().kind = dds::KEEP_ALL_HISTORY_QOS;
  qos.resource_limits().max_samples = depth;
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().max_samples_per_instance = depth;
  qos.resource_limits().allocated_samples = loan ? depth : 4;
  qos.resource_limits().extra_samples = 4;
  if (loan) {
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_MEMORY_MODE;
    qos.data_sharing().automatic();
  } else {
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.data_sharing().off();
  }
}

/// A heartbeat while fragments are still on the line requests data that is on its way, and the message is sent twice.
/// So data carries no heartbeat, and one follows after several messages. The history has to hold that many messages.
void SetSparseHeartbeats(dds::DataWriterQos& qos, const Lane& lane) {
  qos.reliable_writer_qos().disable_heartbeat_piggyback = true;
  qos.reliable_writer_qos().times.heartbeatPeriod = eprosima::fastrtps::Duration_t(0.1 + 4e-6 * lane.transit_us);
  qos.resource_limits().max_samples = kSparseDepth;
  qos.resource_limits().max_samples_per_instance = kSparseDepth;
}

/// A lane's topic.
class Topic {
 public:
  Topic(dds::DomainParticipant* participant, const Lane& lane, bool loan)
      : participant_(participant),
        type_(loan ? static_cast<dds::TopicDataType*>(new PlainType(lane.size_bytes))
                   : new SequenceType(lane.size_bytes)) {
    type_.register_type(participant);
    topic_ = participant->create_topic(lane.name, type_.get_type_name(), dds::TOPIC_QOS_DEFAULT);
    if (topic_ == nullptr) Fail("Fast DDS cannot create a topic");
  }
  Topic(const Topic&) = delete;
  Topic& operator=(const Topic&) = delete;
  ~Topic() {
    participant_->delete_topic(topic_);
    participant_->unregister_type(type_.get_type_name());
  }
  [[nodiscard]] dds::Topic* get() const { return topic_; }

 private:
  dds::DomainParticipant* participant_;
  dds::TypeSupport type_;
  dds::Topic* topic_ = nullptr;
};

class SequenceListener final : public dds::DataReaderListener {
 public:
  explicit SequenceListener(Sink& sink) : sink_(sink) {}
  void on_data_available(dds::DataReader* reader) override {
    dds::SampleInfo info;
    while (reader->take_next_sample(&bytes_, &info) == Code::RETCODE_OK) {
      if (info.valid_data) sink_.Note(bytes_.data(), bytes_.size());
    }
  }

 private:
  Sink& sink_;
  SequenceType::Bytes bytes_;
};

class LoanListener final : public dds::DataReaderListener {
 public:
  LoanListener(Sink& sink, std::size_t size_bytes) : sink_(sink), size_bytes_(size_bytes) {}
  void on_data_available(dds::DataReader* reader) override {
    struct FirstByte {
      std::uint8_t value;
    };
    dds::LoanableSequence<FirstByte> samples;
    dds::SampleInfoSeq infos;
    while (reader->take(samples, infos) == Code::RETCODE_OK) {
      for (dds::LoanableCollection::size_type i = 0; i < infos.length(); ++i) {
        if (infos[i].valid_data) sink_.Note(&samples[i], size_bytes_);
      }
      reader->return_loan(samples, infos);
    }
  }

 private:
  Sink& sink_;
  std::size_t size_bytes_;
};

class FastInlet final : public Inlet {
 public:
  FastInlet(dds::DomainParticipant* participant, const Lane& lane, bool loan, Sink& sink)
      : participant_(participant), topic_(participant, lane, loan) {
    if (loan) {
      listener_ = std::make_unique<LoanListener>(sink, lane.size_bytes);
    } else {
      listener_ = std::make_unique<SequenceListener>(sink);
    }
    subscriber_ = participant->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
    dds::DataReaderQos qos = dds::DATAREADER_QOS_DEFAULT;
    SetQos(qos, lane, loan);
    reader_ = subscriber_->create_datareader(topic_.get(), qos, listener_.get());
    if (reader_ == nullptr) Fail("Fast DDS cannot create a reader");
  }
  ~FastInlet() override {
    subscriber_->delete_datareader(reader_);
    participant_->delete_subscriber(subscriber_);
  }

 private:
  dds::DomainParticipant* participant_;
  Topic topic_;
  std::unique_ptr<dds::DataReaderListener> listener_;
  dds::Subscriber* subscriber_;
  dds::DataReader* reader_;
};

class FastOutlet final : public Outlet {
 public:
  FastOutlet(dds::DomainParticipant* participant, const Lane& lane, bool loan, bool tuned)
      : participant_(participant), topic_(participant, lane, loan), loan_(loan), bytes_(lane.size_bytes) {
    Fill(reinterpret_cast<std::byte*>(bytes_.data()), bytes_.size());
    publisher_ = participant->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    dds::DataWriterQos qos = dds::DATAWRITER_QOS_DEFAULT;
    SetQos(qos, lane, loan);
    // A thread of the library sends fragments, so larger samples need the asynchronous mode.
    qos.publish_mode().kind =
        lane.size_bytes > kLargestUnfragmented ? dds::ASYNCHRONOUS_PUBLISH_MODE : dds::SYNCHRONOUS_PUBLISH_MODE;
    if (tuned && lane.size_bytes > kLargestUnfragmented) SetSparseHeartbeats(qos, lane);
    writer_ = publisher_->create_datawriter(topic_.get(), qos, &matched_);
    if (writer_ == nullptr) Fail("Fast DDS cannot create a writer");
  }
  ~FastOutlet() override {
    publisher_->delete_datawriter(writer_);
    participant_->delete_publisher(publisher_);
  }
  std::byte* Take() override {
    if (matched_.count == 0) return nullptr;
    if (!loan_) return reinterpret_cast<std::byte*>(bytes_.data());
    if (writer_->loan_sample(lent_) == Code::RETCODE_OK) return static_cast<std::byte*>(lent_);
    std::this_thread::yield();
    return nullptr;
  }
  bool Publish() override {
    if (!loan_) return writer_->write(&bytes_);
    if (writer_->write(lent_)) return true;
    writer_->discard_loan(lent_);
    return false;
  }
  [[nodiscard]] bool lends() const override { return loan_; }

 private:
  class Matched final : public dds::DataWriterListener {
   public:
    std::atomic<int> count{0};
    void on_publication_matched(dds::DataWriter*, const dds::PublicationMatchedStatus& status) override {
      count = status.current_count;
    }
  };
  dds::DomainParticipant* participant_;
  Topic topic_;
  bool loan_;
  SequenceType::Bytes bytes_;
  void* lent_ = nullptr;
  Matched matched_;
  dds::Publisher* publisher_;
  dds::DataWriter* writer_;
};

class FastDds final : public Peer {
 public:
  explicit FastDds(const Task& task) : loan_(task.mode == "loan"), udp_tuned_(task.mode == "udp_tuned") {
    dds::DomainParticipantQos qos = dds::PARTICIPANT_QOS_DEFAULT;
    qos.name("hgros_bench");
    qos.transport().use_builtin_transports = false;
    if (task.mode != "udp" && !udp_tuned_) {
      auto shm = std::make_shared<eprosima::fastdds::rtps::SharedMemTransportDescriptor>();
      if (task.mode == "shm_tuned") {
        shm->segment_size(static_cast<std::uint32_t>(8 * task.largest_bytes() + (4u << 20)));
        shm->max_message_size(static_cast<std::uint32_t>(task.largest_bytes() + 4096));
      }
      qos.transport().user_transports.push_back(shm);
    }
    auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList.emplace_back(task.own_address);
    if (udp_tuned_) udp->receiveBufferSize = kReceiveBufferBytes;
    qos.transport().user_transports.push_back(udp);
    participant_ = dds::DomainParticipantFactory::get_instance()->create_participant(0, qos);
    if (participant_ == nullptr) Fail("Fast DDS cannot create a participant");
  }
  ~FastDds() override { dds::DomainParticipantFactory::get_instance()->delete_participant(participant_); }
  std::unique_ptr<Inlet> Subscribe(const Lane& lane, Sink& sink) override {
    return std::make_unique<FastInlet>(participant_, lane, loan_, sink);
  }
  std::unique_ptr<Outlet> Publish(const Lane& lane) override {
    return std::make_unique<FastOutlet>(participant_, lane, loan_, udp_tuned_);
  }

 private:
  bool loan_;
  bool udp_tuned_;
  dds::DomainParticipant* participant_ = nullptr;
};

}  // namespace

std::unique_ptr<Peer> MakePeer(const Task& task) {
  const auto modes = {"shm_udp", "shm_tuned", "udp", "udp_tuned", "loan"};
  if (std::find(modes.begin(), modes.end(), task.mode) == modes.end())
    Fail("Fast DDS has no mode \"" + task.mode + "\"");
  return std::make_unique<FastDds>(task);
}

}  // namespace hgros::bench
