#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "bindings.hpp"
#include "bulk_wire.hpp"
#include "session_handle.hpp"
#include "waits.hpp"
#include "wire.hpp"

namespace hgros::python {
namespace {

using Clock = std::chrono::steady_clock;

// Copying fewer bytes takes less time than letting another thread of Python run.
constexpr std::size_t kHeldGilBytes = 16 * 1024;
// Before the bytes of a loan, for all other fields of the message.
constexpr std::size_t kHeadroomBytes = 1024;

// Publishes with the GIL released; waits at most `timeout_s` for room, with none or 0 not at all.
template <class Data>
PublishStatus PublishOrWait(const PublisherHandle& publisher, const Data& data, std::optional<double> timeout_s) {
  if (!timeout_s || !(*timeout_s > 0)) {
    const GilRelease released;
    return publisher.Publish(data, {});
  }
  const auto deadline = Clock::now() + Nanoseconds(*timeout_s);
  while (true) {
    PublishStatus status{};
    {
      const GilRelease released;
      status = publisher.Publish(data, std::min(deadline, Clock::now() + kSignalsEvery));
    }
    if (status != PublishStatus::kTimedOut || Clock::now() >= deadline) return status;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
}

int PublishBytes(const PublisherHandle& publisher, const py::bytes& data, std::optional<double> timeout_s) {
  char* begin = nullptr;
  py::ssize_t size = 0;
  if (PyBytes_AsStringAndSize(data.ptr(), &begin, &size) != 0) throw py::error_already_set();
  const Bytes bytes(reinterpret_cast<const std::byte*>(begin), static_cast<std::size_t>(size));
  if (bytes.size() < kHeldGilBytes && !timeout_s && !publisher.beside_others())
    return static_cast<int>(publisher.Publish(bytes, {}));
  return static_cast<int>(PublishOrWait(publisher, bytes, timeout_s));
}

// Memory for the large field of a message, with room before it for the rest.
class LoanedBytes : public OfProcess {
 public:
  LoanedBytes(Block block, std::size_t size_bytes) : block_(std::move(block)), size_bytes_(size_bytes) {}

  [[nodiscard]] std::byte* data() { return block_.writable().data() + kHeadroomBytes; }
  [[nodiscard]] std::size_t size() const noexcept { return size_bytes_; }
  [[nodiscard]] bool published() const noexcept { return published_; }

  // The rest of the message, then field `number` with the bytes. On any status except kOk it can be published again.
  PublishStatus Publish(const PublisherHandle& publisher, const std::string& head, int number,
                        std::optional<double> timeout_s) {
    const std::string before = head + BulkPrefix(number, size_bytes_);
    PublishStatus status{};
    if (before.size() <= kHeadroomBytes) {
      std::memcpy(data() - before.size(), before.data(), before.size());
      const Bytes whole(data() - before.size(), before.size() + size_bytes_);
      status = PublishOrWait(publisher, Payload{whole, block_.payload().owner}, timeout_s);
    } else {
      status = PublishOrWait(publisher, Larger(publisher, before).payload(), timeout_s);
    }
    published_ = status == PublishStatus::kOk;
    return status;
  }

 private:
  // A copy, with more room before the bytes.
  [[nodiscard]] Block Larger(const PublisherHandle& publisher, const std::string& before) {
    const GilRelease released;
    Block larger = publisher.Loan(before.size() + size_bytes_);
    std::memcpy(larger.writable().data(), before.data(), before.size());
    std::memcpy(larger.writable().data() + before.size(), data(), size_bytes_);
    return larger;
  }

  Block block_;
  std::size_t size_bytes_;
  bool published_ = false;
};

Owned<LoanedBytes> Loan(const PublisherHandle& publisher, std::size_t size_bytes) {
  if (size_bytes > kMaxMessageBytes) {
    throw py::value_error("A loan has at most " + std::to_string(kMaxMessageBytes) + " bytes, not " +
                          std::to_string(size_bytes) + ".");
  }
  const GilRelease released;
  return MakeOwned<LoanedBytes>(publisher.Loan(kHeadroomBytes + size_bytes), size_bytes);
}

}  // namespace

void BindPublisher(py::module_& module) {
  py::class_<LoanedBytes, Owned<LoanedBytes>>(module, "LoanedBytes", py::buffer_protocol(),
                                              "Bytes that receivers will read in place.")
      .def_buffer([](LoanedBytes& loan) {
        return py::buffer_info(loan.data(), 1, "B", 1, {static_cast<py::ssize_t>(loan.size())}, {1},
                               /*readonly=*/loan.published());
      })
      .def(
          "publish",
          [](LoanedBytes& loan, const PublisherHandle& publisher, const std::string& head, int number,
             std::optional<double> timeout) {
            return static_cast<int>(loan.Publish(publisher, head, number, timeout));
          },
          py::arg("publisher"), py::arg("head"), py::arg("number"), py::arg("timeout"));
  py::class_<PublisherHandle, Owned<PublisherHandle>>(module, "Publisher", "Publishes bytes on one channel.")
      .def("publish", &PublishBytes, py::arg("data"), py::arg("timeout") = py::none())
      .def(
          "publish_wire",
          [](const PublisherHandle& publisher, const Wire& wire, std::optional<double> timeout) {
            return static_cast<int>(PublishOrWait(publisher, wire.data(), timeout));
          },
          py::arg("wire"), py::arg("timeout"))
      .def("loan", &Loan, py::arg("size"));
}

}  // namespace hgros::python
