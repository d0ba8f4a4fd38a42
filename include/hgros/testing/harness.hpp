#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <typeinfo>
#include <utility>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/codec/message.hpp"
#include "hgros/component/component.hpp"
#include "hgros/component/components.hpp"

namespace hgros::testing {

struct HarnessOptions {
  std::string params = {};                            ///< YAML of the component's parameters: "cell_size_m: 0.1".
  Time start = {};                                    ///< What the clock shows at the beginning.
  std::shared_ptr<const RawMessage> state = nullptr;  ///< What another instance has saved.
};

/// The part of Harness that does not depend on the component's class.
class HGROS_EXPORT AnyHarness {
 public:
  AnyHarness(const AnyHarness&) = delete;
  AnyHarness& operator=(const AnyHarness&) = delete;

  /// Lets time pass: each timer that becomes due fires at its moment.
  void Step(Duration time);
  [[nodiscard]] Time now() const;

  [[nodiscard]] ComponentStatus status() const;
  [[nodiscard]] const ComponentDescription& description() const;
  /// What the component has written into its log.
  [[nodiscard]] std::vector<std::string> lines() const;
  /// Null if the class has no Save.
  [[nodiscard]] std::shared_ptr<const RawMessage> Save();
  [[nodiscard]] ParamServer& params() const;

 protected:
  AnyHarness(const ComponentType& type, const HarnessOptions& options);
  ~AnyHarness();

  [[nodiscard]] Session& session() const;
  [[nodiscard]] void* FindObject(const std::type_info& type) const;
  /// Throws Error unless the component subscribes to the channel.
  void RequireInput(std::string_view channel) const;
  static void RequireOk(PublishStatus status);
  /// Throws Error unless the component serves it.
  void RequireService(std::string_view service) const;
  /// Throws Error unless the component advertises the channel, with that type.
  [[nodiscard]] std::vector<AnyMessage> TakeAny(std::string_view channel, const TypeInfo& type);

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

/// Tests a component like a function: in this thread, without other processes, and without waiting.
///
///     hgros::testing::Harness<Mapper> mapper({.params = "cell_size_m: 0.1"});
///     mapper.Feed("scan", scan);                                  // Its callback has run when Feed returns.
///     mapper.Step(std::chrono::seconds(1));                       // Its timers have run.
///     EXPECT_EQ(mapper.Take<foxglove::Grid>("map").size(), 1U);   // What it has published.
///
/// Every callback runs in the thread that publishes, in the order of the messages. The clock stands still but for
/// Step(); stamps of messages are its time.
///
/// Threading: one thread.
/// Errors:    throws Error for a channel or service that the component does not have (it names the nearest), and for
///            what Components::Add refuses.
template <Component C>
class Harness : public AnyHarness {
 public:
  explicit Harness(const HarnessOptions& options = {}) : AnyHarness(ComponentTypeOf<C>("harness/Component"), options) {}

  [[nodiscard]] C* operator->() const { return static_cast<C*>(FindObject(typeid(C))); }

  /// Gives the component one message: a value, which is copied, or a unique_ptr or shared_ptr.
  template <class M>
  void Feed(std::string_view channel, M&& message) {
    RequireInput(channel);
    RequireOk(session().ToAny(channel, std::forward<M>(message)));
  }
  /// What the component has published on the channel since the last Take, the oldest first. The first Take has the
  /// latched messages of the constructor, too.
  template <class T>
  [[nodiscard]] std::vector<std::shared_ptr<const T>> Take(std::string_view channel) {
    std::vector<std::shared_ptr<const T>> taken;
    for (AnyMessage& message : TakeAny(channel, TypeOf<T>())) {
      taken.emplace_back(std::static_pointer_cast<const T>(std::move(message)));
    }
    return taken;
  }
  /// Calls a service of the component.
  template <class Request, class Reply>
  [[nodiscard]] CallResult<Reply> Call(std::string_view service, const Request& request) {
    RequireService(service);
    return session().template Call<Request, Reply>(service, request, std::chrono::seconds(10)).Wait();
  }
};

}  // namespace hgros::testing
