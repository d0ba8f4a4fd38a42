// For any bytes: a bulk message parses exactly if the generated class does, and has the same contents.
#include <google/protobuf/stubs/logging.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <string>

#include "foxglove/PointCloud.pb.h"
#include "foxglove/RawImage.pb.h"
#include "hgros/codec/message.hpp"

namespace {

void Require(bool holds) {
  if (!holds) std::abort();
}

template <class T>
void Compare(hgros::Bytes wire, const std::shared_ptr<const void>& owner) {
  T plain;
  const bool parses = plain.ParseFromArray(wire.data(), static_cast<int>(wire.size()));
  const hgros::TypeInfo& type = hgros::TypeOf<hgros::Bulk<T>>();
  const hgros::AnyMessage message = type.decode({wire, owner});
  Require((message != nullptr) == parses);
  if (!parses) return;
  const auto bulk = std::static_pointer_cast<const hgros::Bulk<T>>(message);
  Require(hgros::AsText(bulk->bytes()) == plain.data());
  const auto converted = std::static_pointer_cast<const T>(type.to_other(message));
  Require(converted != nullptr && converted->SerializeAsString() == plain.SerializeAsString());
  // What was read is written as the same message.
  const hgros::Payload written = type.encode(message);
  T again;
  Require(written.owner && again.ParseFromArray(written.bytes.data(), static_cast<int>(written.bytes.size())));
  Require(again.SerializeAsString() == plain.SerializeAsString());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const google::protobuf::LogSilencer* const silence = new google::protobuf::LogSilencer;
  (void)silence;
  const auto wire = std::make_shared<const std::string>(reinterpret_cast<const char*>(data), size);
  Compare<foxglove::PointCloud>(hgros::AsBytes(*wire), wire);
  Compare<foxglove::PointCloud>(hgros::AsBytes(*wire), nullptr);
  Compare<foxglove::RawImage>(hgros::AsBytes(*wire), wire);
  return 0;
}
