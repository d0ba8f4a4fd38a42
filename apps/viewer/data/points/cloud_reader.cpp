#include "viewer/data/points/cloud_reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <optional>
#include <span>

#include "hgros/codec/point_cloud_view.hpp"
#include "hgros/tf/transform_cloud.hpp"
#include "viewer/data/points/far_points.hpp"
#include "viewer/data/stamp.hpp"

namespace hgros::viewer {
namespace {

/// One value of every point, stored as any numeric type.
class FieldValues {
 public:
  /// Errors: `fault` says what is wrong with the field.
  static std::optional<FieldValues> Of(const PackedElements& points, std::string_view name, std::string& fault) {
    const auto field = std::ranges::find(points.fields(), name, &ElementField::name);
    if (field == points.fields().end()) {
      fault = "The cloud has no field \"" + std::string(name) + "\".";
      return std::nullopt;
    }
    switch (static_cast<NumericType>(field->type)) {
      case NumericType::kUint8: return Checked<std::uint8_t>(points, name, fault);
      case NumericType::kInt8: return Checked<std::int8_t>(points, name, fault);
      case NumericType::kUint16: return Checked<std::uint16_t>(points, name, fault);
      case NumericType::kInt16: return Checked<std::int16_t>(points, name, fault);
      case NumericType::kUint32: return Checked<std::uint32_t>(points, name, fault);
      case NumericType::kInt32: return Checked<std::int32_t>(points, name, fault);
      case NumericType::kFloat32: return Checked<float>(points, name, fault);
      case NumericType::kFloat64: return Checked<double>(points, name, fault);
      case NumericType::kUnknown: break;
    }
    fault = "The field \"" + std::string(name) + "\" has an unknown numeric type.";
    return std::nullopt;
  }

  [[nodiscard]] double operator[](std::size_t index) const { return read_(first_ + index * stride_); }
  /// The bits as they are stored, for colors packed into one word.
  [[nodiscard]] std::uint32_t Word(std::size_t index) const {
    std::uint32_t word = 0;
    std::memcpy(&word, first_ + index * stride_, sizeof word);
    return word;
  }
  [[nodiscard]] NumericType type() const { return type_; }
  [[nodiscard]] bool word_sized() const {
    return type_ == NumericType::kUint32 || type_ == NumericType::kInt32 || type_ == NumericType::kFloat32;
  }

 private:
  template <class T>
  static std::optional<FieldValues> Checked(const PackedElements& points, std::string_view name, std::string& fault) {
    const auto view = points.Field<T>(name);
    if (!view) {
      fault = view.fault();
      return std::nullopt;
    }
    FieldValues values;
    const auto field = std::ranges::find(points.fields(), name, &ElementField::name);
    values.first_ = points.data().data() + field->offset_bytes;
    values.stride_ = points.stride_bytes();
    values.type_ = NumericTypeOf<T>();
    values.read_ = [](const std::byte* at) {
      T value;
      std::memcpy(&value, at, sizeof value);
      return static_cast<double>(value);
    };
    return values;
  }

  const std::byte* first_ = nullptr;
  std::size_t stride_ = 0;
  NumericType type_ = NumericType::kUnknown;
  double (*read_)(const std::byte*) = nullptr;
};

constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
constexpr std::array<std::string_view, 8> kColors = {"rgb", "rgba", "red", "green", "blue", "alpha", "r", "g"};

bool IsColor(std::string_view name) { return std::ranges::find(kColors, name) != kColors.end() || name == "b"; }

/// How the colors of a cloud are stored.
class ColorFields {
 public:
  explicit ColorFields(const PackedElements& points) {
    std::string ignored;
    for (const std::string_view name : {"rgba", "rgb"}) {
      auto word = FieldValues::Of(points, name, ignored);
      if (word && word->word_sized()) {
        packed_ = *word;
        return;
      }
    }
    for (const auto& names : {std::array<std::string_view, 3>{"red", "green", "blue"}, {"r", "g", "b"}}) {
      for (std::size_t i = 0; i < 3; ++i) channels_[i] = FieldValues::Of(points, names[i], ignored);
      if (channels_[0] && channels_[1] && channels_[2]) return;
    }
  }

  [[nodiscard]] bool any() const { return packed_ || (channels_[0] && channels_[1] && channels_[2]); }
  [[nodiscard]] std::uint32_t operator[](std::size_t index) const {
    if (packed_) {  // 0xAARRGGBB, as PCL has it
      const std::uint32_t word = packed_->Word(index);
      return 0xFF000000U | (word & 0xFFU) << 16U | (word & 0xFF00U) | (word >> 16U & 0xFFU);
    }
    std::uint32_t color = 0xFF000000U;
    for (std::size_t i = 0; i < 3; ++i) {
      const bool fraction =
          channels_[i]->type() == NumericType::kFloat32 || channels_[i]->type() == NumericType::kFloat64;
      const double value = std::clamp((*channels_[i])[index] * (fraction ? 255.0 : 1.0), 0.0, 255.0);
      color |= (std::isfinite(value) ? static_cast<std::uint32_t>(value) : 0U) << (8U * i);
    }
    return color;
  }

 private:
  std::optional<FieldValues> packed_;
  std::array<std::optional<FieldValues>, 3> channels_;
};

/// A place among most of the points: the median of a sample, along each axis.
Eigen::Vector3d MiddleOf(const std::array<std::optional<FieldValues>, 3>& axes, std::size_t count) {
  constexpr std::size_t kSample = 101;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  std::vector<double> sample;
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    if (!axes[axis]) continue;
    sample.clear();
    for (std::size_t i = 0; i < count; i += count / kSample + 1) {
      if (const double at = (*axes[axis])[i]; std::isfinite(at)) sample.push_back(at);
    }
    if (sample.empty()) continue;
    const auto half = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 2);
    std::ranges::nth_element(sample, half);
    middle[static_cast<Eigen::Index>(axis)] = *half;
  }
  return middle;
}

/// The field that is used if none is requested.
std::string UsualScalar(const std::vector<std::string>& fields) {
  for (const std::string_view name : {"intensity", "i", "reflectivity", "intensities"}) {
    if (std::ranges::find(fields, name) != fields.end()) return std::string(name);
  }
  return {};
}

}  // namespace

std::string ReadCloud(const Bulk<foxglove::PointCloud>& cloud, std::string_view scalar, PointBatch& batch) {
  const foxglove::PointCloud& head = cloud.head();
  PointBatch read;
  read.frame = head.frame_id();
  read.stamp = StampOf(head.timestamp());
  read.T_frame_points = tf::PoseIn(head);
  if (cloud.bytes().empty()) {
    batch = std::move(read);
    return {};
  }
  const auto points = ViewPoints(cloud);
  if (!points) return points.fault();

  std::string fault;
  std::array<std::optional<FieldValues>, 3> axes;
  for (std::size_t i = 0; i < 3; ++i) {
    axes[i] = FieldValues::Of(*points, kAxes[i], fault);
    if (axes[i]) continue;
    const bool flat = i == 2 && std::ranges::find(points->fields(), "z", &ElementField::name) == points->fields().end();
    if (!flat) return fault;  // A cloud without z is in the plane z = 0.
  }
  for (const ElementField& field : points->fields()) {
    if (std::ranges::find(kAxes, field.name) == kAxes.end() && !IsColor(field.name)) read.fields.push_back(field.name);
  }
  read.scalar_name = scalar.empty() ? UsualScalar(read.fields) : std::string(scalar);
  std::optional<FieldValues> values;
  if (!read.scalar_name.empty()) {
    values = FieldValues::Of(*points, read.scalar_name, fault);
    if (!values) return fault;
  }
  const ColorFields colors(*points);

  const std::size_t count = points->size();
  read.positions.reserve(count);
  if (values) read.scalars.reserve(count);
  if (colors.any()) read.colors.reserve(count);
  // Doubles may be too large for floats, so the common offset of most points becomes a part of the pose.
  const bool wide = axes[0]->type() == NumericType::kFloat64 || axes[1]->type() == NumericType::kFloat64;
  const Eigen::Vector3d shift = wide ? MiddleOf(axes, count) : Eigen::Vector3d(0, 0, 0);
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d at((*axes[0])[i], (*axes[1])[i], axes[2] ? (*axes[2])[i] : 0.0);
    if (!at.allFinite()) {
      ++read.left_out;
      continue;
    }
    read.positions.emplace_back((at - shift).cast<float>());
    if (values) read.scalars.push_back(static_cast<float>((*values)[i]));
    if (colors.any()) read.colors.push_back(colors[i]);
  }
  read.T_frame_points.translation += read.T_frame_points.rotation * shift;
  LeaveOutFar(read);
  batch = std::move(read);
  return {};
}

}  // namespace hgros::viewer
