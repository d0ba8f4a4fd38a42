#include "hgros/base/own_descriptor.hpp"

#include <pthread.h>
#include <unistd.h>

#include <cerrno>
#include <mutex>
#include <utility>

namespace hgros {

/// All open OwnDescriptors of the process. Closes them in a forked child.
struct OwnDescriptors {
  // Never destroyed: a thread may still fork while the program ends.
  static OwnDescriptors& Get() {
    static auto* const all = new OwnDescriptors;
    return *all;
  }

  OwnDescriptors() {
    pthread_atfork([] { Get().mutex.lock(); }, [] { Get().mutex.unlock(); }, [] { Get().CloseAllInChild(); });
  }

  void Add(OwnDescriptor& one) noexcept {
    one.before_ = nullptr;
    one.after_ = first;
    if (first != nullptr) first->before_ = &one;
    first = &one;
  }
  void Remove(OwnDescriptor& one) noexcept {
    (one.before_ != nullptr ? one.before_->after_ : first) = one.after_;
    if (one.after_ != nullptr) one.after_->before_ = one.before_;
  }
  void CloseAllInChild() noexcept {
    while (first != nullptr) {
      OwnDescriptor& one = *first;
      first = one.after_;
      close(one.fd_);
      one.fd_ = -1;
    }
    mutex.unlock();
  }

  std::mutex mutex;  // Held across a fork by the thread that forks.
  OwnDescriptor* first = nullptr;
};

OwnDescriptor::OwnDescriptor(const std::function<int()>& open) {
  OwnDescriptors& all = OwnDescriptors::Get();
  const std::scoped_lock lock(all.mutex);
  fd_ = open();
  if (fd_ >= 0) all.Add(*this);
}

OwnDescriptor::OwnDescriptor(OwnDescriptor&& other) noexcept { TakeFrom(other); }

OwnDescriptor& OwnDescriptor::operator=(OwnDescriptor&& other) noexcept {
  if (this != &other) {
    Close();
    TakeFrom(other);
  }
  return *this;
}

OwnDescriptor::~OwnDescriptor() { Close(); }

void OwnDescriptor::TakeFrom(OwnDescriptor& other) noexcept {
  OwnDescriptors& all = OwnDescriptors::Get();
  const std::scoped_lock lock(all.mutex);
  if (other.fd_ < 0) return;
  all.Remove(other);
  fd_ = std::exchange(other.fd_, -1);
  all.Add(*this);
}

void OwnDescriptor::Close() noexcept {
  if (fd_ < 0) return;  // Also in a forked child, where CloseAllInChild() has closed it.
  OwnDescriptors& all = OwnDescriptors::Get();
  const std::scoped_lock lock(all.mutex);
  if (fd_ < 0) return;
  all.Remove(*this);
  const int error = errno;
  close(std::exchange(fd_, -1));
  errno = error;
}

}  // namespace hgros
