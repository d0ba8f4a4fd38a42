#include "hgros/tf/transform_cloud.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace hgros::tf {
namespace {

using Quad = float __attribute__((vector_size(16)));

// The offsets of a vector's three numbers in each element.
using Offsets = std::array<std::size_t, 3>;

std::size_t OffsetOf(const PackedElements& elements, std::string_view name) {
  const auto& fields = elements.fields();
  const auto field = std::find_if(fields.begin(), fields.end(), [&](const ElementField& f) { return f.name == name; });
  return static_cast<std::size_t>(field->offset_bytes);
}

bool Has(const PackedElements& elements, std::string_view name) {
  return std::any_of(elements.fields().begin(), elements.fields().end(),
                     [&](const ElementField& field) { return field.name == name; });
}

template <class Scalar>
std::string FindVector(const PackedElements& elements, const std::array<const char*, 3>& names, Offsets& offsets) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto values = elements.Field<Scalar>(names[i]);
    if (!values) return values.fault();
    offsets[i] = OffsetOf(elements, names[i]);
  }
  return {};
}

// Reads four floats of each element at once. The fourth is another field, or no field, and stays unchanged.
void TransformPacked(const Eigen::Matrix3f& turn, const Eigen::Vector3f& shift, std::size_t offset, std::size_t stride,
                     std::span<std::byte> out) {
  const auto column = [](const Eigen::Vector3f& v) { return Quad{v.x(), v.y(), v.z(), 0}; };
  const Quad x = column(turn.col(0));
  const Quad y = column(turn.col(1));
  const Quad z = column(turn.col(2));
  const Quad t = column(shift);
  for (std::byte* at = out.data() + offset; at < out.data() + out.size(); at += stride) {
    Quad point;
    std::memcpy(&point, at, sizeof point);
    Quad moved = x * point[0] + y * point[1] + (z * point[2] + t);
    moved[3] = point[3];
    std::memcpy(at, &moved, sizeof moved);
  }
}

template <class Scalar>
void TransformVectors(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation, const Offsets& offsets,
                      std::size_t stride, std::span<std::byte> out) {
  const Eigen::Matrix<Scalar, 3, 3>& turn = rotation.cast<Scalar>();
  const Eigen::Matrix<Scalar, 3, 1>& shift = translation.cast<Scalar>();
  if constexpr (sizeof(Scalar) == 4) {
    if (offsets[1] == offsets[0] + 4 && offsets[2] == offsets[0] + 8 && offsets[0] + sizeof(Quad) <= stride) {
      TransformPacked(turn, shift, offsets[0], stride, out);
      return;
    }
  }
  for (std::size_t first = 0; first < out.size(); first += stride) {
    Eigen::Matrix<Scalar, 3, 1> point;
    for (int i = 0; i < 3; ++i) {
      std::memcpy(&point[i], out.data() + first + offsets[static_cast<std::size_t>(i)], sizeof(Scalar));
    }
    point = turn * point + shift;
    for (int i = 0; i < 3; ++i) {
      std::memcpy(out.data() + first + offsets[static_cast<std::size_t>(i)], &point[i], sizeof(Scalar));
    }
  }
}

template <class Scalar>
std::string TransformAs(const RigidTransform& T, const PackedElements& elements, std::span<std::byte> out) {
  Offsets points{};
  Offsets normals{};
  if (std::string fault = FindVector<Scalar>(elements, {"x", "y", "z"}, points); !fault.empty()) return fault;
  const bool has_normals = Has(elements, "normal_x");
  if (has_normals) {
    std::string fault = FindVector<Scalar>(elements, {"normal_x", "normal_y", "normal_z"}, normals);
    if (!fault.empty()) return fault;
  }
  const Eigen::Matrix3d rotation = T.rotation.toRotationMatrix();
  TransformVectors<Scalar>(rotation, T.translation, points, elements.stride_bytes(), out);
  if (has_normals) {
    TransformVectors<Scalar>(rotation, Eigen::Vector3d::Zero(), normals, elements.stride_bytes(), out);
  }
  return {};
}

}  // namespace

std::string TransformElements(const RigidTransform& T, const PackedElements& elements, std::span<std::byte> out) {
  return elements.Field<double>("x") ? TransformAs<double>(T, elements, out) : TransformAs<float>(T, elements, out);
}

}  // namespace hgros::tf
