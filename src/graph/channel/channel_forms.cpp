// Channels with a second C++ type of the same wire form, or with raw subscribers.
#include <utility>

#include "graph/channel/channel.hpp"
#include "graph/channel/two_forms.hpp"
#include "hgros/codec/run_time_type.hpp"

namespace hgros {
namespace {

// An offer whose message is wrapped when it is taken.
struct WrappingOffer {
  const MessageOffer& inner;
  const TypeInfo& type;
  const Channel& channel;

  static AnyMessage Take(void* context) {
    const auto& self = *static_cast<const WrappingOffer*>(context);
    return two_forms::Wrap(self.inner.take(self.inner.context), self.type, &self.channel);
  }
};

}  // namespace

bool Channel::TryUseWith(const TypeInfo& type, const CallSite& where) {
  if (IsAnyType(type)) return true;
  if (IsAnyType(this->type())) AdoptType(type, where);
  if (IsRunTimeType(type)) {
    if (!AreInterchangeable(this->type(), type)) return false;
    AddRawForm();
    return true;
  }
  if (IsRunTimeType(this->type())) AdoptType(type, where);
  const TypeInfo& first = this->type();
  if (&first == &type || IsSameType(first, type)) return true;
  const TypeInfo* other = other_type_.load(std::memory_order_acquire);
  if (other == nullptr && two_forms::Fit(first, type)) {
    AddSecondType(type);
    other = other_type_.load(std::memory_order_acquire);
  }
  return other != nullptr && IsSameType(*other, type);
}

// Earlier messages are raw and wrapped as such. A C++ type takes the place of a type that is known at run time only.
void Channel::AdoptType(const TypeInfo& type, const CallSite& where) {
  const std::scoped_lock lock(wiring_mutex_);
  const TypeInfo& now = this->type();
  const bool narrows = IsRunTimeType(now) && !IsRunTimeType(type) && AreInterchangeable(now, type);
  if (!IsAnyType(now) && !narrows) return;
  declared_at_ = where.ToString();
  type_.store(&type, std::memory_order_release);
}

std::string Channel::declared_at() const {
  const std::scoped_lock lock(wiring_mutex_);
  return declared_at_;
}

// Every node learns it before the first message of the second type can be published.
void Channel::AddSecondType(const TypeInfo& other) {
  const std::scoped_lock lock(wiring_mutex_, latch_mutex_);
  if (other_type_.load(std::memory_order_relaxed) != nullptr) return;
  for (const std::shared_ptr<Node>& node : current_fanout_->nodes) node->ExpectTwoForms();
  latched_messages_.Replace([this](AnyMessage message) {
    if (two_forms::TypeOfWrapped(message, this) != nullptr) return message;
    return two_forms::Wrap(std::move(message), type(), this);
  });
  other_type_.store(&other, std::memory_order_release);
  raw_.Keep();
  wrapping_.fetch_or(kSeveralForms, std::memory_order_release);
}

// Before the first raw message can be published, every node knows that one may come.
void Channel::AddRawForm() {
  const bool several = (wrapping_.load(std::memory_order_acquire) & kSeveralForms) != 0;
  if (several && raw_.expected()) return;
  const std::scoped_lock lock(wiring_mutex_, latch_mutex_);
  raw_.Keep();
  raw_.Expect(current_fanout_->nodes);
  wrapping_.fetch_or(kSeveralForms, std::memory_order_release);
}

PublishStatus Channel::TryOneOfSeveral(const MessageOffer& offer, Reach reach) noexcept {
  if (offer.message == nullptr) return PublishStatus::kEmpty;
  const TypeInfo& offered = offer.type();
  const TypeInfo& first = this->type();
  const TypeInfo* const other = other_type_.load(std::memory_order_acquire);
  const bool shared_raw = (wrapping_.load(std::memory_order_relaxed) & kSharedRaw) != 0;
  if (other == nullptr && !IsAnyType(offered) && !shared_raw) return TryAs(offer, first, reach);
  const bool as_first = other == nullptr || IsSameType(offered, first);
  const TypeInfo& type = IsAnyType(offered) ? AnyType() : as_first ? first : *other;
  WrappingOffer wrapping{offer, type, *this};
  return TryAs({offer.message, WrappingOffer::Take, &wrapping, offer.type}, type, reach);
}

AnyMessage Channel::InForm(const AnyMessage& message, const TypeInfo& wanted) {
  if (raw_.MayEnd()) {  // This is called for each message, so it does not wait.
    const std::unique_lock lock(wiring_mutex_, std::try_to_lock);
    if (lock) raw_.End(current_fanout_->nodes);
  }
  return two_forms::As(message, wanted, type(), this, [&](const AnyMessage& one, const TypeInfo& from) {
    AnyMessage made;
    if (IsAnyType(wanted)) {
      made = raw_forms_.ToRaw(one, from);
    } else if (IsAnyType(from)) {
      made = raw_forms_.FromRaw(*static_cast<const RawMessage*>(one.get()), wanted);
    } else {
      made = two_forms::Convert(one, from, wanted);
    }
    (made != nullptr ? counts_.converted : counts_.not_converted).fetch_add(1, std::memory_order_relaxed);
    return made;
  });
}

AnyMessage Channel::Wrapped(AnyMessage message, const TypeInfo& type) {
  if (!IsAnyType(type)) {
    return other_type_.load(std::memory_order_acquire) == nullptr ? message
                                                                  : two_forms::Wrap(std::move(message), type, this);
  }
  AnyMessage raw = two_forms::Wrap(std::move(message), type, this, raw_.messages());
  if (!raw_.expected()) {
    const std::scoped_lock lock(wiring_mutex_);
    raw_.Expect(current_fanout_->nodes);
  }
  return raw;
}

const TypeInfo& Channel::TypeOfMessage(const AnyMessage& message) const noexcept {
  const TypeInfo* const type = two_forms::TypeOfWrapped(message, this);
  return type == nullptr ? this->type() : *type;
}

}  // namespace hgros
