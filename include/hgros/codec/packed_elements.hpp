#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "hgros/base/bytes.hpp"
#include "hgros/base/export.hpp"
#include "hgros/codec/strided_view.hpp"
#include "hgros/codec/view_result.hpp"

namespace hgros {

/// How a value is stored, with the numbers of foxglove.PackedElementField.NumericType.
enum class NumericType : std::uint8_t {
  kUnknown = 0,
  kUint8 = 1,
  kInt8 = 2,
  kUint16 = 3,
  kInt16 = 4,
  kUint32 = 5,
  kInt32 = 6,
  kFloat32 = 7,
  kFloat64 = 8,
};

/// The type for a C++ type; kUnknown if there is none.
template <class T>
[[nodiscard]] constexpr NumericType NumericTypeOf() noexcept {
  if (std::is_same_v<T, std::uint8_t>) return NumericType::kUint8;
  if (std::is_same_v<T, std::int8_t>) return NumericType::kInt8;
  if (std::is_same_v<T, std::uint16_t>) return NumericType::kUint16;
  if (std::is_same_v<T, std::int16_t>) return NumericType::kInt16;
  if (std::is_same_v<T, std::uint32_t>) return NumericType::kUint32;
  if (std::is_same_v<T, std::int32_t>) return NumericType::kInt32;
  if (std::is_same_v<T, float>) return NumericType::kFloat32;
  if (std::is_same_v<T, double>) return NumericType::kFloat64;
  return NumericType::kUnknown;
}

/// Where a value is inside each element, as the message describes it.
struct ElementField {
  std::string name;
  std::uint64_t offset_bytes = 0;  ///< From the start of the element.
  int type = 0;                    ///< A NumericType, or any other number from the sender.
};

/// A packed array of equal elements (points, cells) with named values. Borrows the bytes.
/// Thread safety: as a value; reading is const.
class HGROS_EXPORT PackedElements {
 public:
  /// `data` is a whole number of elements of `stride_bytes` each. Fields are checked when they are requested.
  [[nodiscard]] static ViewResult<PackedElements> Of(Bytes data, std::uint64_t stride_bytes,
                                                     std::vector<ElementField> fields);

  /// Number of elements.
  [[nodiscard]] std::size_t size() const noexcept { return data_.size() / stride_; }
  [[nodiscard]] std::size_t stride_bytes() const noexcept { return stride_; }
  [[nodiscard]] Bytes data() const noexcept { return data_; }
  [[nodiscard]] const std::vector<ElementField>& fields() const noexcept { return fields_; }

  /// One value of every element, in order; T must be the type in which the message stores it. Every value is inside its
  /// element.
  template <class T>
  [[nodiscard]] ViewResult<StridedView<T>> Field(std::string_view name) const {
    static_assert(NumericTypeOf<T>() != NumericType::kUnknown,
                  "A value is std::uint8_t, int8_t, uint16_t, int16_t, uint32_t, int32_t, float or double.");
    std::size_t offset_bytes = 0;
    std::string fault = Find(name, NumericTypeOf<T>(), sizeof(T), offset_bytes);
    if (!fault.empty()) return ViewResult<StridedView<T>>::Fault(std::move(fault));
    return StridedView<T>(data_.data() + offset_bytes, stride_, size());
  }

 private:
  PackedElements(Bytes data, std::size_t stride_bytes, std::vector<ElementField> fields)
      : data_(data), stride_(stride_bytes), fields_(std::move(fields)) {}
  [[nodiscard]] std::string Find(std::string_view name, NumericType type, std::size_t size_bytes,
                                 std::size_t& offset_bytes) const;

  Bytes data_;
  std::size_t stride_;
  std::vector<ElementField> fields_;
};

}  // namespace hgros
