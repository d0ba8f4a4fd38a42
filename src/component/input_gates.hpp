#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "component/input_gate.hpp"
#include "hgros/graph/executor.hpp"
#include "hgros/graph/invoke.hpp"
#include "hgros/graph/queue.hpp"

namespace hgros {

// How an input is wired.
struct InputWiring {
  std::string node;
  std::string channel;
  const TypeInfo* type;
  Invoke invoke;
  Queue queue;
  Executor executor;
  bool operator==(const InputWiring&) const = default;
};

// The gates of the inputs of a component that can be saved. When another instance is constructed in its place, an input
// that is wired as before keeps its gate, with the callback of the new instance.
//
// Thread safety: all functions.
class InputGates {
 public:
  struct Asked {
    std::shared_ptr<InputGate> fresh;  // To be wired; null: it is wired already.
    std::shared_ptr<InputGate> ends;   // Was wired otherwise under the same name; may be null.
  };
  [[nodiscard]] Asked Ask(InputWiring wiring, AnyCallback callback, std::shared_ptr<ComponentGuard> guard);
  // Another instance follows while all are held. Gates that are made until EndAgain() are held, too.
  void BeginAgain();
  // Returns those that it has not asked for.
  [[nodiscard]] std::vector<std::shared_ptr<InputGate>> EndAgain();
  [[nodiscard]] std::vector<std::shared_ptr<InputGate>> all() const;

 private:
  struct Lasting {
    InputWiring wiring;
    std::shared_ptr<InputGate> gate;
    bool used = true;  // By the instance that is there.
  };
  mutable std::mutex mutex_;
  std::vector<Lasting> gates_;
  bool again_ = false;
};

}  // namespace hgros
