#include "sides.hpp"

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "hgros/hgros.h"
#include "hgros/hgros.hpp"

namespace hgros::bench {
namespace {

constexpr const char* kChannel = "blocks";
constexpr const char* kType = "bench/Bytes";
constexpr std::size_t kLent = 256 * 1024;

void Require(hgros_status status) {
  if (status == HGROS_OK) return;
  std::fprintf(stderr, "%s\n", hgros_last_error());
  std::exit(2);
}

std::string Yaml(const std::string& domain) { return "discovery: {domain: \"" + domain + "\"}"; }

hgros_session* OpenC(const std::string& domain) {
  hgros_session* session = nullptr;
  Require(hgros_session_open(Yaml(domain).c_str(), nullptr, &session));
  return session;
}

class CSender final : public PairSender {
 public:
  explicit CSender(const std::string& domain) : session_(OpenC(domain)) {
    hgros_schema* schema = nullptr;
    Require(hgros_schema_create(kType, HGROS_ENCODING_CUSTOM, 0, nullptr, 0, &schema));
    Require(hgros_publisher_open(session_, kChannel, schema, nullptr, &publisher_));
    hgros_schema_free(schema);
    Require(hgros_session_wait_for_subscribers(session_, kChannel, 1, 20'000'000'000));
  }
  ~CSender() override {
    hgros_publisher_close(publisher_);
    hgros_session_close(session_);
  }
  // Filling a loan is not measured: only its stamp is written.
  void Send(const std::shared_ptr<Block>& block) override {
    if (block->size() < kLent) return Require(hgros_publish(publisher_, block->bytes().data(), block->size()));
    hgros_loan* loan = nullptr;
    Require(hgros_loan_open(publisher_, block->size(), &loan));
    std::memcpy(hgros_loan_data(loan, nullptr), block->bytes().data(), sizeof(Stamp));
    Require(hgros_loan_publish(loan, 0));
    hgros_loan_free(loan);
  }

 private:
  hgros_session* session_;
  hgros_publisher* publisher_ = nullptr;
};

class CReceiver final : public PairReceiver {
 public:
  CReceiver(const std::string& domain, PairControl& control) : session_(OpenC(domain)) {
    hgros_subscribe_options options{};
    options.size = sizeof options;
    options.executor = HGROS_EXECUTOR_INLINE;
    Require(hgros_subscribe(
        session_, kChannel, &options,
        [](void* user, const hgros_message* message) {
          std::size_t size = 0;
          const auto* const data = static_cast<const std::byte*>(hgros_message_data(message, &size));
          NoteArrival(*static_cast<PairControl*>(user), Bytes(data, size));
        },
        &control, nullptr, &subscription_));
  }
  ~CReceiver() override {
    hgros_subscription_close(subscription_);
    hgros_session_close(session_);
  }

 private:
  hgros_session* session_;
  hgros_subscription* subscription_ = nullptr;
};

class CppSender final : public PairSender {
 public:
  explicit CppSender(const std::string& domain)
      : session_(Config::Parse(Yaml(domain))),
        publish_(session_.AdvertiseRaw(kChannel, MessageSchema{kType, Encoding::kCustom, 0, {}})) {
    if (session_.WaitForSubscribers(kChannel, 1, std::chrono::seconds(20))) return;
    std::fprintf(stderr, "the receiver did not start within 20 s\n");
    std::exit(2);
  }
  void Send(const std::shared_ptr<Block>& block) override {
    PublishStatus status = PublishStatus::kOk;
    if (block->size() < kLent) {
      status = publish_({block->bytes(), nullptr});
    } else {
      const auto loan = session_.Loan<Block>(kChannel, block->size());
      std::memcpy(loan->writable().data(), block->bytes().data(), sizeof(Stamp));
      status = publish_(loan->payload());
    }
    if (status == PublishStatus::kOk) return;
    std::fprintf(stderr, "publishing failed with \"%s\"\n", std::string(ToString(status)).c_str());
    std::exit(2);
  }

 private:
  Session session_;
  RawPublisher publish_;
};

class CppReceiver final : public PairReceiver {
 public:
  CppReceiver(const std::string& domain, PairControl& control)
      : session_(Config::Parse(Yaml(domain))),
        subscription_(
            session_.FromAnyRaw(kChannel, Invoke::kSerial,
                                [&control](const RawMessage& message) { NoteArrival(control, message.data.bytes); },
                                {{}, {}, Executor::Inline()})) {}

 private:
  Session session_;
  Subscription subscription_;
};

}  // namespace

std::unique_ptr<PairSender> MakeCSender(const std::string& domain) { return std::make_unique<CSender>(domain); }
std::unique_ptr<PairReceiver> MakeCReceiver(const std::string& domain, PairControl& control) {
  return std::make_unique<CReceiver>(domain, control);
}
std::unique_ptr<PairSender> MakeCppSender(const std::string& domain) { return std::make_unique<CppSender>(domain); }
std::unique_ptr<PairReceiver> MakeCppReceiver(const std::string& domain, PairControl& control) {
  return std::make_unique<CppReceiver>(domain, control);
}

}  // namespace hgros::bench
