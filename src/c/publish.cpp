#include "hgros/c/publish.h"

#include "c/handles.hpp"
#include "c/raw.hpp"
#include "hgros/clock/time.hpp"

namespace hgros::c {

// What a publisher and its loans share.
struct Publishing {
  std::shared_ptr<Life> life;
  std::string channel;
  RawPublisher publish;
};

}  // namespace hgros::c

struct hgros_publisher {
  std::shared_ptr<const hgros::c::Publishing> of;
};

struct hgros_loan {
  std::shared_ptr<const hgros::c::Publishing> of;
  std::unique_ptr<hgros::Block> block;  // Null once it is published.
};

namespace hgros::c {
namespace {

hgros_status StatusOf(PublishStatus status, const Publishing& on) noexcept {
  const std::string& channel = on.channel;
  switch (status) {
    case PublishStatus::kOk: return HGROS_OK;
    case PublishStatus::kFull: return Fail(HGROS_FULL, {"A lossless subscriber of channel ", channel, " has no room."});
    case PublishStatus::kStopped:
    case PublishStatus::kClosed: return Fail(HGROS_CLOSED, on.life->why_closed());
    case PublishStatus::kWouldDeadlock:
      return Fail(HGROS_WOULD_DEADLOCK, {"A callback may not wait for room on channel ", channel,
                                         ". Publish with a timeout of 0, or on another thread."});
    case PublishStatus::kTimedOut:
      return Fail(HGROS_TIMED_OUT, {"A lossless subscriber of channel ", channel, " had no room until the timeout."});
    case PublishStatus::kEmpty: return Fail(HGROS_INVALID_ARGUMENT, "There is no message to publish.");
    case PublishStatus::kTooLarge:
      return Fail(HGROS_TOO_LARGE, {"The message on channel ", channel,
                                    " is larger than 1 GiB, the most that passes between sessions."});
    case PublishStatus::kNoMemory:
      return Fail(HGROS_NO_MEMORY, {"There is no memory to send the message on channel ", channel, "."});
  }
  return Fail(HGROS_ERROR, "Publishing has failed.");
}

// The caller may publish the same bytes again.
bool MayBeRepeated(PublishStatus status) noexcept {
  return status == PublishStatus::kFull || status == PublishStatus::kTimedOut ||
         status == PublishStatus::kWouldDeadlock;
}

PublishStatus PublishIn(const Publishing& on, const Payload& payload, std::int64_t timeout_ns) {
  if (on.life->closed()) return PublishStatus::kClosed;
  return timeout_ns == 0 ? on.publish(payload)
                         : on.publish.Wait(payload, DeadlineIn(Timeout(timeout_ns)), on.life->stop());
}

}  // namespace
}  // namespace hgros::c

namespace c = hgros::c;

hgros_status hgros_publisher_open(hgros_session* session, const char* channel, const hgros_schema* schema,
                                  const hgros_publish_options* options, hgros_publisher** publisher) {
  return c::Creating(publisher, [&] {
    const hgros_session& on = c::Opened(session);
    const std::string name(c::Text(channel, "channel"));
    const auto latched = static_cast<std::size_t>(c::OptionsFrom(options).latched);
    auto publish = on.session->AdvertiseRaw(name, c::SchemaIn(schema, "schema"), {.latched = latched}, c::kFromC);
    return std::make_unique<hgros_publisher>(
        hgros_publisher{std::make_shared<const c::Publishing>(c::Publishing{on.life, name, std::move(publish)})});
  });
}

void hgros_publisher_close(hgros_publisher* publisher) { delete publisher; }

hgros_status hgros_publish(const hgros_publisher* publisher, const void* data, size_t size) {
  return hgros_publish_wait(publisher, data, size, 0);
}

hgros_status hgros_publish_wait(const hgros_publisher* publisher, const void* data, size_t size, int64_t timeout_ns) {
  return c::Guarded([&] {
    const c::Publishing& on = *c::Given(publisher, "publisher").of;
    return c::StatusOf(c::PublishIn(on, c::Borrowed(data, size), timeout_ns), on);
  });
}

hgros_status hgros_publish_borrowed(const hgros_publisher* publisher, const void* data, size_t size, void* user,
                                    hgros_release release, int64_t timeout_ns) {
  return c::Guarded([&] {
    const auto kept =
        c::KeepUser(user, release, publisher == nullptr ? c::CallbackOf{} : c::CallbackOf{publisher->of->life, {}});
    const hgros::Payload payload{c::Borrowed(data, size).bytes, kept};
    const c::Publishing& on = *c::Given(publisher, "publisher").of;
    const hgros::PublishStatus status = c::PublishIn(on, payload, timeout_ns);
    if (c::MayBeRepeated(status)) kept->GiveBack();  // Nobody got the message, so nobody else has it.
    return c::StatusOf(status, on);
  });
}

hgros_status hgros_loan_open(const hgros_publisher* publisher, size_t size, hgros_loan** loan) {
  if (loan != nullptr) *loan = nullptr;
  return c::Guarded([&] {
    const auto& of = c::Given(publisher, "publisher").of;
    return of->life->Use([&](hgros::Session& session) {
      auto block = session.Loan<hgros::Block>(of->channel, size);
      auto made = std::make_unique<hgros_loan>(hgros_loan{of, std::move(block)});
      hgros_loan*& place = c::Given(loan, "the place for the result");
      place = made.release();
      return hgros_status{HGROS_OK};
    });
  });
}

void* hgros_loan_data(hgros_loan* loan, size_t* size) {
  const bool open = loan != nullptr && loan->block != nullptr;
  if (size != nullptr) *size = open ? loan->block->size() : 0;
  return open ? loan->block->writable().data() : nullptr;
}

hgros_status hgros_loan_publish(hgros_loan* loan, int64_t timeout_ns) {
  return c::Guarded([&] {
    hgros_loan& lent = c::Given(loan, "loan");
    if (!lent.block) return c::Fail(HGROS_INVALID_ARGUMENT, "The loan was published before. Open a new one.");
    const c::Publishing& on = *lent.of;
    const hgros_status status = c::StatusOf(c::PublishIn(on, lent.block->payload(), timeout_ns), on);
    if (status == HGROS_OK) lent.block.reset();
    return status;
  });
}

void hgros_loan_free(hgros_loan* loan) { delete loan; }
