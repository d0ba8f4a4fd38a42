#include "hgros/codec/message.hpp"

#include <gtest/gtest.h>

#include <mutex>
#include <stdexcept>

#include "foxglove/Vector3.pb.h"

namespace hgros_test {

struct Plain {
  double x = 0;
  double y = 0;
};

struct PaperStyle {
  std::string text;
  bool SerializeToString(std::string* out) const {
    *out = text;
    return true;
  }
  bool ParseFromString(const std::string& in) {
    text = in;
    return in != "refused";
  }
};

struct NamedPaperStyle : PaperStyle {
  static constexpr std::string_view kTypeName = "test.Named";
};

struct Foreign {
  std::vector<int> numbers;
};

struct PlainButCustom {
  int value = 0;
};

struct Shared {
  hgros::Payload payload;
};

struct Throwing {
  bool SerializeToString(std::string*) const { throw std::runtime_error("cannot"); }
  bool ParseFromString(const std::string&) { throw std::runtime_error("cannot"); }
};

struct Local {
  std::mutex mutex;
};

/// Another C++ form of foxglove.Vector3.
struct Arrow {
  double x = 0;
};

}  // namespace hgros_test

template <>
struct hgros::CustomCodec<hgros_test::Foreign> {
  static constexpr std::string_view kTypeName = "test.Foreign";
  static std::uint64_t Fingerprint() { return 77; }
  static std::size_t MemoryBytes(const hgros_test::Foreign& value) { return 4 * value.numbers.size(); }
  static bool Serialize(const hgros_test::Foreign& value, std::string& bytes) {
    if (value.numbers.empty()) return false;
    for (const int number : value.numbers) bytes += static_cast<char>(number);
    return true;
  }
  static bool Parse(std::string_view bytes, hgros_test::Foreign& value) {
    for (const char c : bytes) value.numbers.push_back(c);
    return !bytes.empty();
  }
};

template <>
struct hgros::CustomCodec<hgros_test::PlainButCustom> {
  static std::string TypeName() { return "test.PlainButCustom"; }
  static std::size_t MemoryBytes(const hgros_test::PlainButCustom&) { throw std::out_of_range("no size"); }
  static bool Serialize(const hgros_test::PlainButCustom& value, std::string& bytes) {
    bytes = std::to_string(value.value);
    return true;
  }
  static bool Parse(std::string_view bytes, hgros_test::PlainButCustom& value) {
    value.value = std::stoi(std::string(bytes));
    return true;
  }
};

template <>
struct hgros::CustomCodec<hgros_test::Shared> {
  static constexpr std::string_view kTypeName = "test.Shared";
  static Payload Encode(const std::shared_ptr<const hgros_test::Shared>& message) { return message->payload; }
  static std::shared_ptr<const hgros_test::Shared> Decode(const Payload& payload) {
    return std::make_shared<const hgros_test::Shared>(hgros_test::Shared{payload});
  }
};

template <>
struct hgros::CustomCodec<hgros_test::Arrow> {
  using Schema = foxglove::Vector3;
  static bool Serialize(const hgros_test::Arrow& arrow, std::string& bytes) {
    foxglove::Vector3 vector;
    vector.set_x(arrow.x);
    return vector.SerializeToString(&bytes);
  }
  static bool Parse(std::string_view bytes, hgros_test::Arrow& arrow) {
    foxglove::Vector3 vector;
    if (!vector.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return false;
    arrow.x = vector.x();
    return true;
  }
};

namespace hgros::message_test {
namespace {

using namespace hgros_test;

template <class T>
std::shared_ptr<const T> RoundTrip(T value) {
  const TypeInfo& info = TypeOf<T>();
  const Payload payload = info.encode(std::make_shared<const T>(std::move(value)));
  return payload.owner ? std::static_pointer_cast<const T>(info.decode(payload)) : nullptr;
}

TEST(Message, PrefersCustomThenProtobufThenOwnMethodsThenPlain) {
  EXPECT_EQ(TypeOf<Foreign>().encoding, Encoding::kCustom);
  EXPECT_EQ(TypeOf<PlainButCustom>().encoding, Encoding::kCustom);
  EXPECT_EQ(TypeOf<PlainButCustom>().name, "test.PlainButCustom");
  EXPECT_EQ(TypeOf<foxglove::Vector3>().encoding, Encoding::kProtobuf);  // It also has the methods of the paper.
  EXPECT_EQ(TypeOf<PaperStyle>().encoding, Encoding::kCustom);
  EXPECT_EQ(TypeOf<Plain>().encoding, Encoding::kPlain);
  EXPECT_EQ(TypeOf<Local>().encoding, Encoding::kNone);
  EXPECT_EQ(&TypeOf<Plain>(), &TypeOf<Plain>()) << "it is created once";
}

TEST(Message, ConceptAcceptsTypesThatCanLeaveTheProcess) {
  static_assert(Message<Foreign> && Message<foxglove::Vector3> && Message<PaperStyle> && Message<Plain>);
  static_assert(Message<int> && Message<double> && Message<Block>);
  static_assert(!Message<Local> && !Message<std::string> && !Message<std::vector<int>> && !Message<int*>);
  static_assert(!Message<const Plain> && !Message<Plain&> && !Message<void> && !Message<int[3]>);
  static_assert(!Message<google::protobuf::Message> && !Message<std::function<void()>>);
}

TEST(Message, LocalTypeHasItsCppNameAndNoCodec) {
  const TypeInfo& info = TypeOf<Local>();
  EXPECT_EQ(info.name, "hgros_test::Local");
  EXPECT_EQ(info.cpp_type, typeid(Local));
  EXPECT_EQ(info.encode, nullptr);
  EXPECT_EQ(info.decode, nullptr);
  EXPECT_EQ(info.descriptor, nullptr);
  EXPECT_EQ(info.descriptor_set, nullptr);
  const Local local;
  EXPECT_EQ(info.memory_bytes(&local), sizeof(Local));
}

TEST(CustomCodec, WritesAndReadsAnUnmodifiedType) {
  const auto back = RoundTrip(Foreign{{1, 2, 3}});
  ASSERT_NE(back, nullptr);
  EXPECT_EQ(back->numbers, (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(TypeOf<Foreign>().name, "test.Foreign");
  EXPECT_EQ(TypeOf<Foreign>().fingerprint, 77U);
  const Foreign five{{1, 2, 3, 4, 5}};
  EXPECT_EQ(TypeOf<Foreign>().memory_bytes(&five), 20U);
  const PlainButCustom plain{};
  EXPECT_EQ(TypeOf<PlainButCustom>().memory_bytes(&plain), sizeof plain) << "although its codec throws";
}

TEST(CustomCodec, MayRefuseToWriteAndToReadOrThrow) {
  EXPECT_FALSE(TypeOf<Foreign>().encode(std::make_shared<const Foreign>()).owner);
  EXPECT_EQ(TypeOf<Foreign>().decode(Payload{}), nullptr);
  EXPECT_FALSE(TypeOf<Throwing>().encode(std::make_shared<const Throwing>()).owner);
  EXPECT_EQ(TypeOf<Throwing>().decode(Payload{AsBytes("x"), nullptr}), nullptr);
  EXPECT_EQ(TypeOf<PlainButCustom>().decode(Payload{AsBytes("no number"), nullptr}), nullptr);
}

TEST(CustomCodec, MayShareBytesInsteadOfCopying) {
  const auto owner = std::make_shared<const std::string>("bytes");
  const auto back = RoundTrip(Shared{{AsBytes(*owner), owner}});
  ASSERT_NE(back, nullptr);
  EXPECT_EQ(static_cast<const void*>(back->payload.bytes.data()), owner->data());
}

TEST(CustomCodec, MayBeAnotherFormOfAProtobufMessage) {
  const TypeInfo& arrow = TypeOf<Arrow>();
  const TypeInfo& vector = TypeOf<foxglove::Vector3>();
  EXPECT_EQ(arrow.encoding, Encoding::kProtobuf);
  EXPECT_EQ(arrow.name, vector.name);
  EXPECT_EQ(arrow.fingerprint, vector.fingerprint);
  EXPECT_EQ(arrow.descriptor(), vector.descriptor());
  EXPECT_NE(arrow.cpp_type, vector.cpp_type);
  const auto plain = std::static_pointer_cast<const foxglove::Vector3>(
      vector.decode(arrow.encode(std::make_shared<const Arrow>(Arrow{2.5}))));
  ASSERT_NE(plain, nullptr);
  EXPECT_EQ(plain->x(), 2.5);
}

TEST(SelfSerialization, UsesTheMethodsOfThePaperAndTheNameOfTheTypeOrOfCpp) {
  const auto back = RoundTrip(PaperStyle{"hello"});
  ASSERT_NE(back, nullptr);
  EXPECT_EQ(back->text, "hello");
  EXPECT_EQ(RoundTrip(PaperStyle{"refused"}), nullptr);
  EXPECT_EQ(TypeOf<PaperStyle>().name, "hgros_test::PaperStyle");
  EXPECT_EQ(TypeOf<NamedPaperStyle>().name, "test.Named");
}

}  // namespace
}  // namespace hgros::message_test
