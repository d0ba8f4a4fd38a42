#pragma once

#include <memory>
#include <utility>

namespace hgros::python {

/// How many forks led from the process that loaded the module to this one.
inline int forks = 0;

/// Belongs to the process that made it. In a forked child it is neither used nor destroyed: threads that only the
/// parent has may have held its mutexes at the fork, and memory that it keeps is given back by the parent.
class OfProcess {
 public:
  /// Whether this process was forked from that of the object.
  [[nodiscard]] bool of_parent() const noexcept { return made_ != forks; }
  /// Errors: throws Error in a forked child.
  void RefuseInChild() const {
    if (of_parent()) ThrowOfParent();
  }

 protected:
  OfProcess() = default;
  ~OfProcess() = default;

 private:
  [[noreturn]] static void ThrowOfParent();

  int made_ = forks;
};

/// Does nothing in a forked child.
struct DeleteInOwnProcess {
  template <class T>
  void operator()(T* object) const {
    if (!object->of_parent()) delete object;
  }
};

template <class T>
using Owned = std::unique_ptr<T, DeleteInOwnProcess>;

template <class T, class... Args>
[[nodiscard]] Owned<T> MakeOwned(Args&&... args) {
  return Owned<T>(new T(std::forward<Args>(args)...));
}

template <class T, class... Args>
[[nodiscard]] std::shared_ptr<T> MakeShared(Args&&... args) {
  return MakeOwned<T>(std::forward<Args>(args)...);
}

/// Once, before anything is made.
void CountForks();

}  // namespace hgros::python
