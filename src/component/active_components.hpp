#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace hgros {

struct OneComponent;

// Which components of a session are active. Once the end has begun, those that still are after kPatience are
// deactivated together, each on a thread of its own, whatever the thread that ends them waits for. They may have motors
// to stop.
//
// Thread safety: all functions.
// Lifetime: longer than the components.
class ActiveComponents {
 public:
  static constexpr std::chrono::milliseconds kPatience{800};  // `hgros run` kills after 1.6 s.
  using Say = std::function<void(std::string_view component, std::string_view warning)>;

  explicit ActiveComponents(Say say) : say_(std::move(say)) {}
  ActiveComponents(const ActiveComponents&) = delete;
  ActiveComponents& operator=(const ActiveComponents&) = delete;
  ~ActiveComponents();

  void Add(OneComponent& one);
  [[nodiscard]] bool Has(OneComponent& one) const;
  // Whether the caller is to deactivate it. If another thread does, this waits for that.
  [[nodiscard]] bool Take(OneComponent& one);

  void BeginEnd() noexcept;
  // No more components are to be activated.
  [[nodiscard]] bool ends() const;

  // While it exists, the thread of the components waits for one of them.
  class Busy {
   public:
    Busy(ActiveComponents& active, const std::string& name) : active_(active), before_(active.SetBusy(name)) {}
    Busy(const Busy&) = delete;
    Busy& operator=(const Busy&) = delete;
    ~Busy() { (void)active_.SetBusy(before_); }

   private:
    ActiveComponents& active_;
    const std::string before_;
  };

 private:
  std::string SetBusy(std::string name);
  void Watch(const std::stop_token& stop);
  void Deactivate(OneComponent& one);

  const Say say_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  bool ends_ = false;
  std::string busy_;
  std::vector<OneComponent*> active_;  // In the order of their Activate().
  std::set<OneComponent*> taken_;      // Are deactivated by another thread now.
  std::vector<std::jthread> threads_;  // One for each of these.
  std::jthread watch_;                 // Ends first.
};

}  // namespace hgros
