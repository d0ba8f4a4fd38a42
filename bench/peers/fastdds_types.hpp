#pragma once

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <vector>

#include <fastdds/dds/topic/TopicDataType.hpp>

namespace hgros::bench {

/// `sequence<octet>` of IDL. Serialized as 4 bytes of encapsulation, 4 of length, and the bytes.
class SequenceType final : public eprosima::fastdds::dds::TopicDataType {
 public:
  using Bytes = std::vector<std::uint8_t>;
  explicit SequenceType(std::size_t size_bytes) {
    setName("HgrosBenchSequence");
    m_typeSize = static_cast<std::uint32_t>(size_bytes + kHead);
    m_isGetKeyDefined = false;
  }
  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<const Bytes*>(data);
    const auto length = static_cast<std::uint32_t>(bytes.size());
    payload->encapsulation = CDR_LE;
    payload->length = length + kHead;
    constexpr std::uint8_t kEncapsulation[4] = {0, 1, 0, 0};
    std::memcpy(payload->data, kEncapsulation, 4);
    std::memcpy(payload->data + 4, &length, 4);
    std::memcpy(payload->data + kHead, bytes.data(), length);
    return true;
  }
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
    if (payload->length < kHead) return false;
    std::uint32_t length = 0;
    std::memcpy(&length, payload->data + 4, 4);
    if (length > payload->length - kHead) return false;
    auto& bytes = *static_cast<Bytes*>(data);
    bytes.resize(length);
    std::memcpy(bytes.data(), payload->data + kHead, length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<Bytes*>(data)->size() + kHead); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }

 private:
  static constexpr std::uint32_t kHead = 8;
};

/// A fixed-size array of octets. Its memory is its serialized form, so it can be lent.
class PlainType final : public eprosima::fastdds::dds::TopicDataType {
 public:
  explicit PlainType(std::size_t size_bytes) : size_bytes_(size_bytes) {
    setName(("HgrosBenchPlain" + std::to_string(size_bytes)).c_str());
    m_typeSize = static_cast<std::uint32_t>(size_bytes + kHead);
    m_isGetKeyDefined = false;
  }
  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
    constexpr std::uint8_t kEncapsulation[4] = {0, 1, 0, 0};
    std::memcpy(payload->data, kEncapsulation, kHead);
    std::memcpy(payload->data + kHead, data, size_bytes_);
    payload->encapsulation = CDR_LE;
    payload->length = m_typeSize;
    return true;
  }
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
    std::memcpy(data, payload->data + kHead, size_bytes_);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void*) override {
    return [size = m_typeSize] { return size; };
  }
  void* createData() override { return std::calloc(1, size_bytes_); }
  void deleteData(void* data) override { std::free(data); }
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }
  [[nodiscard]] bool is_bounded() const override { return true; }
  [[nodiscard]] bool is_plain() const override { return true; }
  bool construct_sample(void*) const override { return true; }

 private:
  static constexpr std::uint32_t kHead = 4;
  std::size_t size_bytes_;
};

}  // namespace hgros::bench
