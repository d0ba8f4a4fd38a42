#include <gmock/gmock.h>

#include <cstring>
#include <vector>

#include <foxglove/PointCloud.pb.h>

#include "hgros/tf/transform_cloud.hpp"
#include "hgros/tf/transform_points.hpp"
#include "tf/tf_fixture.hpp"

namespace hgros {
namespace {

using Cloud = Bulk<foxglove::PointCloud>;
using ::testing::HasSubstr;

TEST(Points, AreTransformedInPlaceAndAsACopy) {
  std::mt19937_64 random(3);
  const RigidTransform T = test::RandomTransform(random);
  Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Random(3, 101);
  const Eigen::Matrix3Xd before = points;
  const Eigen::Matrix3Xf as_float = TransformedPoints(T, before.cast<float>());
  TransformPoints(T, points);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d expected = T * Eigen::Vector3d(before.col(i));
    EXPECT_LT((points.col(i) - expected).norm(), 1e-12);
    EXPECT_LT((as_float.col(i).cast<double>() - expected).norm(), 1e-5);
  }
}

TEST(RigidTransform, AgreesWithItsIsometry) {
  std::mt19937_64 random(4);
  const RigidTransform a = test::RandomTransform(random);
  const RigidTransform b = test::RandomTransform(random);
  EXPECT_LT(((a * b).Isometry().matrix() - (a.Isometry() * b.Isometry()).matrix()).norm(), 1e-12);
  EXPECT_LT(test::Difference(a * a.Inverse(), RigidTransform()), 1e-12);
  EXPECT_LT(test::Difference(RigidTransform(a.Isometry()), a), 1e-12);
}

// A cloud of `count` points with fields at these offsets.
struct Layout {
  const char* name;
  std::uint32_t stride;
  std::vector<std::pair<const char*, std::uint32_t>> fields;
  bool is_double = false;
};

template <class Scalar>
void Write(Cloud& cloud, std::size_t at, double value) {
  const auto scalar = static_cast<Scalar>(value);
  std::memcpy(cloud.writable().data() + at, &scalar, sizeof scalar);
}
template <class Scalar>
double Read(const std::byte* at) {
  Scalar scalar;
  std::memcpy(&scalar, at, sizeof scalar);
  return static_cast<double>(scalar);
}

template <class Scalar>
void Check(const Layout& layout) {
  SCOPED_TRACE(layout.name);
  constexpr std::size_t kCount = 57;
  std::mt19937_64 random(5);
  const RigidTransform T = test::RandomTransform(random, 10);
  const RigidTransform pose = test::RandomTransform(random, 10);
  Cloud cloud(kCount * layout.stride);
  cloud.head().set_frame_id("laser");
  cloud.head().set_point_stride(layout.stride);
  auto& at = *cloud.head().mutable_pose()->mutable_position();
  at.set_x(pose.translation.x());
  at.set_y(pose.translation.y());
  at.set_z(pose.translation.z());
  auto& turn = *cloud.head().mutable_pose()->mutable_orientation();
  turn.set_w(pose.rotation.w());
  turn.set_x(pose.rotation.x());
  turn.set_y(pose.rotation.y());
  turn.set_z(pose.rotation.z());
  for (const auto& [name, offset] : layout.fields) {
    auto& field = *cloud.head().add_fields();
    field.set_name(name);
    field.set_offset(offset);
    field.set_type(layout.is_double ? foxglove::PackedElementField::FLOAT64 : foxglove::PackedElementField::FLOAT32);
  }
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.writable()[i] = static_cast<std::byte>(i % 251);
  for (std::size_t i = 0; i < kCount; ++i) {
    for (const auto& [name, offset] : layout.fields) {
      Write<Scalar>(cloud, i * layout.stride + offset, std::uniform_real_distribution<double>(-5, 5)(random));
    }
  }
  const std::vector<std::byte> before(cloud.bytes().begin(), cloud.bytes().end());
  Cloud copy(cloud.size());
  ASSERT_EQ(TransformCloud(T, "map", static_cast<const Cloud&>(cloud), copy), "");
  EXPECT_EQ(cloud.head().frame_id(), "laser");
  EXPECT_EQ(std::memcmp(cloud.bytes().data(), before.data(), before.size()), 0);
  ASSERT_EQ(TransformCloud(T, "map", cloud), "");
  EXPECT_EQ(cloud.head().frame_id(), "map");
  EXPECT_FALSE(cloud.head().has_pose());
  EXPECT_EQ(std::memcmp(cloud.bytes().data(), copy.bytes().data(), cloud.size()), 0);
  std::vector<bool> touched(before.size(), false);
  for (std::size_t i = 0; i < kCount; ++i) {
    for (std::size_t group = 0; group + 2 < layout.fields.size(); group += 3) {
      Eigen::Vector3d was;
      Eigen::Vector3d is;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t place = i * layout.stride + layout.fields[group + k].second;
        was[static_cast<Eigen::Index>(k)] = Read<Scalar>(before.data() + place);
        is[static_cast<Eigen::Index>(k)] = Read<Scalar>(cloud.bytes().data() + place);
        for (std::size_t byte = 0; byte < sizeof(Scalar); ++byte) touched[place + byte] = true;
      }
      const Eigen::Vector3d expected = group == 0 ? T * (pose * was) : (T.rotation * pose.rotation) * was;
      EXPECT_LT((is - expected).norm(), sizeof(Scalar) == 4 ? 2e-5 : 1e-12);
    }
  }
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (touched[i]) continue;
    EXPECT_EQ(cloud.bytes()[i], before[i]) << "byte " << i << " is not a coordinate.";
  }
}

TEST(Clouds, AreTransformedInEveryLayout) {
  Check<float>({"x y z intensity", 16, {{"x", 0}, {"y", 4}, {"z", 8}}});
  Check<float>({"x y z alone", 12, {{"x", 0}, {"y", 4}, {"z", 8}}});
  Check<float>({"behind other fields", 21, {{"x", 5}, {"y", 9}, {"z", 13}}});
  Check<float>({"at the end", 17, {{"x", 5}, {"y", 9}, {"z", 13}}});
  Check<float>({"scattered", 24, {{"x", 8}, {"y", 0}, {"z", 20}}});
  Check<float>({"normals", 32, {{"x", 0}, {"y", 4}, {"z", 8}, {"normal_x", 16}, {"normal_y", 20}, {"normal_z", 24}}});
  Check<double>({"doubles", 32, {{"x", 0}, {"y", 8}, {"z", 16}}, true});
}

TEST(Clouds, ReportInvalidFields) {
  Cloud cloud(32);
  cloud.head().set_point_stride(16);
  EXPECT_THAT(TransformCloud(RigidTransform(), "map", cloud), HasSubstr("x"));
  Cloud larger(48);
  EXPECT_THAT(TransformCloud(RigidTransform(), "map", static_cast<const Cloud&>(cloud), larger), HasSubstr("size"));
  cloud.head().set_point_stride(0);
  EXPECT_NE(TransformCloud(RigidTransform(), "map", cloud), "");
}

}  // namespace
}  // namespace hgros
