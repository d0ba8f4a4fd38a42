#include "hgros/internal/codec/plain_codec.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstring>

#include "hgros/codec/message.hpp"

namespace hgros_test {

enum class Mode : std::uint8_t { kIdle, kRun };

struct Wheel {
  float speed;
  std::int16_t ticks[4];
};

struct Robot {
  bool on;
  Mode mode;
  char name[16];
  double pose[2][3];
  std::array<Wheel, 2> wheels;
  std::uint64_t count;
};

struct Empty {};
struct WithPointer {
  int* where;
};
struct WithPointerInside {
  int count;
  WithPointer inner[2];
};
struct WithView {
  std::string_view text;
};
struct WithReference {
  int& where;
};
struct WithFunction {
  void (*call)();
};
struct WithMemberPointer {
  int Wheel::*member;
};
struct Base {
  int a;
};
struct Derived : Base {
  int b;
};
struct BitFields {
  unsigned low : 3;
  unsigned high : 5;
};
#pragma pack(push, 1)
struct Packed {
  std::uint8_t id;
  std::uint32_t value;
};
#pragma pack(pop)
union Either {
  int number;
  float real;
};
struct Tagged {
  int tag;
  Either value;
};
struct Timed {
  std::chrono::nanoseconds since;
};
class WithConstructor {
 public:
  WithConstructor() = default;
  explicit WithConstructor(int value) : value_(value) {}
  [[nodiscard]] int value() const { return value_; }

 private:
  int value_ = 0;
};
class Vouched {
 public:
  Vouched() = default;
  explicit Vouched(int value) : value_(value) {}
  [[nodiscard]] int value() const { return value_; }

 private:
  int value_ = 0;
};
struct ThirtyFields {
  int a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11, a12, a13, a14, a15, a16, a17, a18, a19, a20, a21, a22, a23, a24,
      a25, a26, a27, a28, a29, a30;
};
struct TwentyFourFields {
  int a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11, a12, a13, a14, a15, a16, a17, a18, a19, a20, a21, a22, a23;
  double a24;
};
struct Large {
  std::array<double, 1000> values;
};

}  // namespace hgros_test

template <>
inline constexpr bool hgros::kPlainValue<hgros_test::Vouched> = true;

namespace hgros {
namespace {

using namespace hgros_test;

TEST(PlainStruct, AcceptsDataWithoutPointers) {
  static_assert(PlainStruct<Robot> && PlainStruct<Wheel> && PlainStruct<Empty> && PlainStruct<Mode>);
  static_assert(PlainStruct<Derived> && PlainStruct<BitFields> && PlainStruct<Packed> && PlainStruct<Tagged>);
  static_assert(PlainStruct<Timed> && PlainStruct<ThirtyFields> && PlainStruct<TwentyFourFields>);
  static_assert(PlainStruct<std::array<float, 100>> && PlainStruct<bool> && PlainStruct<std::byte>);
  static_assert(PlainStruct<Vouched>);
}

TEST(PlainStruct, RefusesVisiblePointers) {
  static_assert(!PlainStruct<WithPointer> && !PlainStruct<WithPointerInside> && !PlainStruct<WithView>);
  static_assert(!PlainStruct<WithReference> && !PlainStruct<WithFunction> && !PlainStruct<WithMemberPointer>);
  static_assert(!PlainStruct<int*> && !PlainStruct<std::nullptr_t> && !PlainStruct<std::string_view>);
  static_assert(!PlainStruct<WithConstructor> && !PlainStruct<std::array<WithPointer, 2>>);
  static_assert(!PlainStruct<std::unique_ptr<int>> && !PlainStruct<std::array<std::string, 2>>);
}

TEST(PlainStruct, HasALayoutTextOfSizesAndKinds) {
  EXPECT_EQ(codec::LayoutText<Wheel>(), "{12/4:f4,[4*s2]}");
  EXPECT_EQ(codec::LayoutText<Robot>(), "{104/8:b1,eu1,[16*c1],[2*[3*f8]],[2*{12/4:f4,[4*s2]}],u8}");
  EXPECT_EQ(codec::LayoutText<Empty>(), "{1/1:}");
  EXPECT_EQ(codec::LayoutText<Packed>(), "{5/1:u1,u4}");
  EXPECT_EQ(codec::LayoutText<BitFields>(), "{4/4:u4,u4}");
  EXPECT_EQ(codec::LayoutText<Derived>(), "o8/4");
  EXPECT_EQ(codec::LayoutText<Tagged>(), "{8/4:s4,o4/4}");
  EXPECT_EQ(codec::LayoutText<ThirtyFields>(), "o120/4");
  EXPECT_EQ(codec::LayoutText<TwentyFourFields>(),
            "{104/8:s4,s4,s4,s4,s4,s4,s4,s4,s4,s4,s4,s4,s4,s4,s4,s4,s4,s4,s4,s4,s4,s4,s4,f8}");
  EXPECT_EQ(codec::LayoutText<Vouched>(), "o4/4");
  EXPECT_EQ((codec::LayoutText<std::array<float, 3>>()), "[3*f4]");
}

TEST(PlainStruct, FingerprintIsTheHashOfNameByteOrderSizeAndLayout) {
  if constexpr (std::endian::native != std::endian::little) GTEST_SKIP();
  EXPECT_EQ(TypeOf<Wheel>().fingerprint, Fingerprint("plain 1\nhgros_test::Wheel\nlittle\n12 4\n{12/4:f4,[4*s2]}\n"));
  EXPECT_EQ(TypeOf<Wheel>().fingerprint, 0xd5ac0d077ff5618bU);
  EXPECT_NE(TypeOf<Wheel>().fingerprint, TypeOf<hgros_test::Packed>().fingerprint);
}

TEST(PlainCodec, SendsTheBytesInPlaceAndReadsThemBack) {
  Robot robot{};
  robot.on = true;
  robot.mode = Mode::kRun;
  robot.pose[1][2] = -0.5;
  robot.wheels[1].ticks[3] = -7;
  robot.count = 1U << 31U;
  const auto sent = std::make_shared<const Robot>(robot);
  const Payload payload = TypeOf<Robot>().encode(sent);
  EXPECT_EQ(static_cast<const void*>(payload.bytes.data()), sent.get());
  EXPECT_EQ(payload.bytes.size(), sizeof(Robot));
  EXPECT_EQ(payload.owner, sent);
  const auto back = std::static_pointer_cast<const Robot>(TypeOf<Robot>().decode(payload));
  ASSERT_NE(back, nullptr);
  EXPECT_TRUE(back->on);
  EXPECT_EQ(back->mode, Mode::kRun);
  EXPECT_EQ(back->pose[1][2], -0.5);
  EXPECT_EQ(back->wheels[1].ticks[3], -7);
  EXPECT_EQ(back->count, 1U << 31U);
}

TEST(PlainCodec, ReadsALargeStructInPlaceAndASmallOneAsACopy) {
  const Payload large = TypeOf<Large>().encode(std::make_shared<const Large>());
  EXPECT_EQ(TypeOf<Large>().decode(large).get(), static_cast<const void*>(large.bytes.data()));
  const Payload small = TypeOf<Wheel>().encode(std::make_shared<const Wheel>());
  EXPECT_NE(TypeOf<Wheel>().decode(small).get(), static_cast<const void*>(small.bytes.data()));
}

TEST(PlainCodec, CopiesMisalignedAndUnownedBytes) {
  const auto buffer = std::make_shared<std::array<std::byte, sizeof(Large) + 16>>();
  Large value{};
  value.values[999] = 3.5;
  std::memcpy(buffer->data() + 1, &value, sizeof value);
  const Payload shifted{Bytes(buffer->data() + 1, sizeof(Large)), buffer};
  const auto back = std::static_pointer_cast<const Large>(TypeOf<Large>().decode(shifted));
  ASSERT_NE(back, nullptr);
  EXPECT_EQ(back->values[999], 3.5);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(back.get()) % alignof(Large), 0U);

  const Payload borrowed{std::as_bytes(std::span(&value, 1)), nullptr};
  EXPECT_NE(TypeOf<Large>().decode(borrowed).get(), static_cast<const void*>(&value));
}

TEST(PlainCodec, RefusesAnotherSize) {
  const auto bytes = std::make_shared<std::array<std::byte, sizeof(Wheel) + 1>>();
  EXPECT_EQ(TypeOf<Wheel>().decode({Bytes(*bytes), bytes}), nullptr);
  EXPECT_EQ(TypeOf<Wheel>().decode({Bytes(*bytes).first(sizeof(Wheel) - 1), bytes}), nullptr);
  EXPECT_NE(TypeOf<Wheel>().decode({Bytes(*bytes).first(sizeof(Wheel)), bytes}), nullptr);
  EXPECT_EQ(TypeOf<Wheel>().decode({}), nullptr);
}

}  // namespace
}  // namespace hgros
