#include "graph/channel/raw_forms.hpp"

#include <algorithm>
#include <new>
#include <utility>

namespace hgros {

// T and Bulk<T> have one schema, so a channel has only one schema of its own.
std::shared_ptr<const MessageSchema> RawForms::OwnSchema(const TypeInfo& type) {
  const std::scoped_lock lock(mutex_);
  if (!own_) own_ = std::make_shared<const MessageSchema>(SchemaOf(type));
  return own_;
}

AnyMessage RawForms::ToRaw(const AnyMessage& message, const TypeInfo& type) {
  if (type.encode == nullptr) return nullptr;
  Payload data;
  if (type.encode_in_place != nullptr) data = type.encode_in_place(message.get());
  try {
    if (data.owner == nullptr) data = type.encode(message);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
  if (data.owner == nullptr) return nullptr;
  return std::make_shared<const RawMessage>(RawMessage{OwnSchema(type), std::move(data)});
}

bool RawForms::Fits(const std::shared_ptr<const MessageSchema>& theirs, const TypeInfo& ours) {
  const std::scoped_lock lock(mutex_);
  const auto known = std::ranges::find_if(compared_, [&](const Compared& one) {
    return one.ours == ours.cpp_type && !one.theirs.owner_before(theirs) && !theirs.owner_before(one.theirs);
  });
  if (known != compared_.end()) return known->fits;
  std::erase_if(compared_, [](const Compared& one) { return one.theirs.expired(); });
  return compared_.emplace_back(Compared{theirs, ours.cpp_type, MisfitOf(*theirs, ours).empty()}).fits;
}

AnyMessage RawForms::FromRaw(const RawMessage& message, const TypeInfo& type) {
  if (type.decode == nullptr || !Fits(message.schema, type)) return nullptr;
  return type.decode(message.data);
}

}  // namespace hgros
