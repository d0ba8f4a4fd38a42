#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/base/log.hpp"
#include "hgros/component/service_client.hpp"
#include "hgros/internal/base/call_site.hpp"
#include "hgros/internal/component/wiring.hpp"
#include "hgros/params/param_error.hpp"
#include "hgros/params/param_server.hpp"
#include "hgros/session/session.hpp"

namespace hgros {

class ClockPublisher;
class ContextCore;
class SimulatedClock;
class Transforms;

/// What a component is constructed from: everything it exchanges with the rest of the robot. It does not know in which
/// thread, process or host it runs: the robot file says so, renames channels, and sets queues and executors of nodes.
///
///     class Mapper {
///      public:
///       explicit Mapper(hgros::Context& context)
///           : cell_(context.Declare("cell_size_m", 0.05, {.unit = "m", .least = 0.001})),
///             maps_(context.Advertise<foxglove::Grid>("map", {.latched = 1})) {
///         context.FromAny<foxglove::LaserScan>("scan", hgros::Invoke::kSerial,
///                                              [this](const foxglove::LaserScan& scan) { Add(scan); });
///       }
///     };
///     HGROS_COMPONENT(Mapper, "slam2d/Mapper")
///
/// Ordering:  callbacks, handlers and timers begin after the constructor, and end before the destructor. Publish from
///            Activate() and from callbacks: in the constructor the component has no state yet.
/// Threading: thread-safe. Use it from the constructor, or keep a reference: it lives longer than the component.
/// Errors:    wiring throws Error. If the constructor lets it pass, the component is not started, and the error shown.
class HGROS_EXPORT Context {
 public:
  /// For Components.
  explicit Context(ContextCore& core) noexcept : core_(core) {}
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  /// The component's name in the robot, such as "mapper".
  [[nodiscard]] const std::string& name() const noexcept;

  /// As Session::Advertise. Advertise in the constructor, so that the robot's channels are known before it runs.
  template <class T>
  [[nodiscard]] Publisher<T> Advertise(std::string_view channel, PublishOptions options = {},
                                       const CallSite& where = CallSite::Current()) {
    RequireMessage<T>();
    return session().Advertise<T>(AddOutput(channel, TypeOf<T>()), options, where);
  }
  [[nodiscard]] RawPublisher AdvertiseRaw(std::string_view channel, const MessageSchema& schema,
                                          PublishOptions options = {}, const CallSite& where = CallSite::Current());
  /// As Session::Loan, for an advertised channel.
  template <class T>
  [[nodiscard]] std::unique_ptr<T> Loan(std::string_view channel, std::size_t size_bytes) {
    return session().Loan<T>(NameHere(channel), size_bytes);
  }

  /// As Session::FromAny, until the component ends. An exception of the callback is logged and counted.
  /// NodeOptions::name is the node's name within the component; empty: the channel's name.
  template <class T, CallbackFor<T> F>
  void FromAny(std::string_view channel, Invoke invoke, F&& callback, NodeOptions options = {},
               const CallSite& where = CallSite::Current()) {
    RequireMessage<T>();
    AddInput({channel, TypeOf<T>(), invoke, where}, EraseCallback<T>(std::forward<F>(callback)), std::move(options));
  }
  template <CallbackFor<RawMessage> F>
  void FromAnyRaw(std::string_view channel, Invoke invoke, F&& callback, NodeOptions options = {},
                  const CallSite& where = CallSite::Current()) {
    AddInput({channel, AnyType(), invoke, where}, EraseCallback<RawMessage>(std::forward<F>(callback)),
             std::move(options));
  }

  /// As Session::Serve, until the component ends.
  template <class Request, class Reply, HandlerFor<Request, Reply> F>
  void Serve(std::string_view service, F&& handler, Invoke invoke = Invoke::kSerial, NodeOptions options = {},
             const CallSite& where = CallSite::Current()) {
    RequireMessage<Request>();
    RequireMessage<Reply>();
    AddService({service, CallTypeOf<Request>(), CallTypeOf<Reply>(), TypeOf<Request>(), TypeOf<Reply>(), invoke, where},
               EraseHandler<Request, Reply>(std::forward<F>(handler)), std::move(options));
  }
  /// A service that the component calls. Ask for it in the constructor, so that it is known before the robot runs.
  template <class Request, class Reply>
  [[nodiscard]] ServiceClient<Request, Reply> Client(std::string_view service) {
    RequireMessage<Request>();
    RequireMessage<Reply>();
    return ServiceClient<Request, Reply>(session(), AddCalled(service, TypeOf<Request>(), TypeOf<Reply>()));
  }

  /// As Session::CreateTimer, from the moment when all components of the robot are ready until this one ends.
  void CreateTimer(std::string_view timer, Duration period, TimerCallback callback, NodeTimerOptions options = {});
  /// The clock of the robot: the system's, or a simulated one.
  [[nodiscard]] const std::shared_ptr<Clock>& clock() const noexcept;

  /// Publishes a simulated clock, which the whole robot follows with `time: simulated`, for as long as the result
  /// exists.
  [[nodiscard]] std::unique_ptr<ClockPublisher> PublishClock(std::shared_ptr<SimulatedClock> clock);

  /// As ParamServer::Declare, in the constructor. A wrong value is an error once that has returned; it gets `fallback`.
  template <class T>
  T Declare(std::string_view path, const T& fallback, ParamInfo info = {}) {
    try {
      return params().Declare(path, fallback, std::move(info));
    } catch (const ParamError& fault) {
      if (!NoteFault(path, fault)) throw;
      return fallback;
    }
  }
  template <std::size_t N>
  std::string Declare(std::string_view path, const char (&fallback)[N], ParamInfo info = {}) {
    return Declare(path, std::string(fallback), std::move(info));
  }
  /// The parameters of this component, which others see under its name.
  [[nodiscard]] ParamServer& params() noexcept;

  /// The transforms of the robot. Static edges that the component sets move along with it. Call it in the constructor
  /// and keep the reference: a robot on several hosts passes transforms between the components that have declared so.
  [[nodiscard]] Transforms& transforms();
  /// Writes lines with the component's name.
  [[nodiscard]] Log& log() noexcept;

  /// The component's work is done. Its callbacks run until the program ends it. Only the first Finish or Fail counts.
  void Finish(std::string result = {});
  /// The component cannot go on, for the reason in `sentence`.
  void Fail(std::string sentence);

 private:
  friend class RawContext;
  [[nodiscard]] Session& session() noexcept;
  [[nodiscard]] bool NoteFault(std::string_view param, const ParamError& fault);
  [[nodiscard]] std::string NameHere(std::string_view name);
  [[nodiscard]] std::string AddOutput(std::string_view channel, const TypeInfo& type);
  [[nodiscard]] std::string AddCalled(std::string_view service, const TypeInfo& request, const TypeInfo& reply);
  void AddInput(const ComponentInput& input, AnyCallback callback, NodeOptions options);
  void AddService(const ServedByComponent& served, AnyHandler handler, NodeOptions options);

  ContextCore& core_;
};

}  // namespace hgros
