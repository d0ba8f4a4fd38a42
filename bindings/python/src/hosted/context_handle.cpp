#include "hosted/context_handle.hpp"

#include <utility>

#include "bindings.hpp"
#include "hgros/base/error.hpp"
#include "hgros/component/raw_context.hpp"
#include "program_line.hpp"

namespace hgros::python {

std::string WorkDesk::Run(const std::function<std::string()>& work) {
  if (thread_ == std::this_thread::get_id()) {
    const py::gil_scoped_acquire acquired;
    return work();
  }
  auto answer = std::make_shared<Answer>();
  inbox_->Push(Work{work, answer});
  return answer->Wait();
}

ContextHandle::Used ContextHandle::Use() const {
  RefuseInChild();
  std::shared_lock lock(mutex_);
  if (context_ == nullptr) {
    throw Error("The component \"" + name_ + "\" has ended.", {}, "Use its context only while it lives.");
  }
  return {std::move(lock), context_};
}

void ContextHandle::End() {
  const std::scoped_lock lock(mutex_);
  context_ = nullptr;
}

std::string ContextHandle::Receive(int target, const std::function<py::tuple()>& arguments) {
  return desk_.Run([&] {
    if (!receiver_) return std::string();
    const py::object result = receiver_(target, *arguments());
    return result.is_none() ? std::string() : result.cast<std::string>();
  });
}

void ContextHandle::Subscribe(const std::string& channel, const MessageSchema* schema, int target,
                              NodeOptions options) {
  options.executor = Executor::Dedicated();  // It waits for Python.
  const auto handle = [self = shared_from_this(), target](const std::shared_ptr<const RawMessage>& message,
                                                          const MessageInfo& info) {
    const Cause cause = Cause::Here();
    (void)self->Receive(target, [&] {
      current_cause = cause;
      return py::make_tuple(WireOf(message->data), std::const_pointer_cast<MessageSchema>(message->schema),
                            InfoOf(info));
    });
  };
  const Used used = Use();
  if (schema == nullptr) {
    used->FromAnyRaw(channel, Invoke::kSerial, handle, std::move(options), ProgramLine());
  } else {
    RawContext(*used.context).FromAny(channel, *schema, Invoke::kSerial, handle, std::move(options), ProgramLine());
  }
}

std::string ContextHandle::Serve(const std::string& service, const MessageSchema& request, const MessageSchema& reply,
                                 int target) {
  NodeOptions options;
  options.executor = Executor::Dedicated();
  const auto handle = [self = shared_from_this(), target](const RawMessage& asked) -> Payload {
    auto data = std::make_shared<const std::string>(self->Receive(target, [&] {
      return py::make_tuple(WireOf(asked.data), std::const_pointer_cast<MessageSchema>(asked.schema));
    }));
    const Bytes bytes = AsBytes(*data);
    return {bytes, std::move(data)};
  };
  const Used used = Use();
  return RawContext(*used.context)
      .Serve(service, request, reply, handle, Invoke::kSerial, std::move(options), ProgramLine());
}

void ContextHandle::CreateTimer(const std::string& timer, std::int64_t period_ns, int target) {
  NodeTimerOptions options;
  options.executor = Executor::Dedicated();
  const auto handle = [self = shared_from_this(), target](const Tick& tick) {
    (void)self->Receive(target,
                        [&] { return py::make_tuple(tick.planned.nanoseconds, tick.now.nanoseconds, tick.missed); });
  };
  Use()->CreateTimer(timer, Duration(period_ns), handle, std::move(options));
}

Owned<PublisherHandle> ContextHandle::Advertise(const std::string& channel, const MessageSchema& schema,
                                                std::size_t latched) {
  auto lend = [weak = weak_from_this(), channel](std::size_t size_bytes) -> std::unique_ptr<Block> {
    const auto self = weak.lock();
    if (!self) return nullptr;
    const std::shared_lock lock(self->mutex_);
    return self->context_ == nullptr ? nullptr : self->context_->Loan<Block>(channel, size_bytes);
  };
  return MakeOwned<PublisherHandle>(
      std::move(lend), Use()->AdvertiseRaw(channel, schema, PublishOptions{.latched = latched}, ProgramLine()),
      /*beside_others=*/true);
}

}  // namespace hgros::python
