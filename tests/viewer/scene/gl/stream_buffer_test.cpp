#include "viewer/scene/gl/stream_buffer.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <string_view>
#include <vector>

#include "viewer/scene/scene_fixture.hpp"

namespace hgros::viewer {
namespace {

using Numbers = std::vector<std::uint32_t>;

Numbers From(std::uint32_t first, std::size_t count) {
  Numbers numbers(count);
  std::iota(numbers.begin(), numbers.end(), first);
  return numbers;
}

void Write(StreamBuffer& buffer, StreamBuffer::Way way, const Numbers& numbers) {
  buffer.Write<std::uint32_t>(way, numbers.size(),
                              [&](std::span<std::uint32_t> to) { std::ranges::copy(numbers, to.begin()); });
}

Numbers Read(GLuint name, std::size_t count) {
  Numbers numbers(count);
  glBindBuffer(GL_ARRAY_BUFFER, name);
  glGetBufferSubData(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(count * sizeof(std::uint32_t)), numbers.data());
  return numbers;
}

/// A command that GL executes later with the contents, like drawing.
GlBuffer TakeCopy(const StreamBuffer& from, std::size_t count) {
  GlBuffer copy = GlBuffer::New();
  const auto bytes = static_cast<GLsizeiptr>(count * sizeof(std::uint32_t));
  glBindBuffer(GL_COPY_WRITE_BUFFER, copy.name());
  glBufferData(GL_COPY_WRITE_BUFFER, bytes, nullptr, GL_STATIC_DRAW);
  glBindBuffer(GL_COPY_READ_BUFFER, from.name());
  glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0, bytes);
  return copy;
}

class StreamBufferIn : public test::DrawingTest, public ::testing::WithParamInterface<StreamBuffer::Way> {
 protected:
  void SetUp() override {
    DrawingTest::SetUp();
    if (IsSkipped()) return;
    if (GetParam() == StreamBuffer::Way::kMapped && StreamBuffer::BestWay() != StreamBuffer::Way::kMapped)
      GTEST_SKIP() << "This driver cannot keep buffers mapped.";
  }
  void TearDown() override {
    if (!IsSkipped()) {
      EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Ways, StreamBufferIn,
                         ::testing::Values(StreamBuffer::Way::kMapped, StreamBuffer::Way::kCopied),
                         [](const auto& way) { return way.param == StreamBuffer::Way::kMapped ? "mapped" : "copied"; });

class StreamBufferWay : public test::DrawingTest {};

TEST_F(StreamBufferWay, IsTheBestThatTheDriverSupports) {
  GLint count = 0;
  glGetIntegerv(GL_NUM_EXTENSIONS, &count);
  bool can = false;
  for (GLuint i = 0; i < static_cast<GLuint>(count); ++i) {
    can |= std::string_view(reinterpret_cast<const char*>(glGetStringi(GL_EXTENSIONS, i))) == "GL_ARB_buffer_storage";
  }
  EXPECT_EQ(StreamBuffer::BestWay(), can ? StreamBuffer::Way::kMapped : StreamBuffer::Way::kCopied);
  const char* const without = std::getenv("HGROS_WITHOUT_MAPPED_BUFFERS");
  if (without != nullptr && std::string_view(without) == "1") {
    EXPECT_FALSE(can) << "this run tests drivers without mapped buffers";
  }
}

TEST_P(StreamBufferIn, HoldsTheLastDataOfAnySize) {
  StreamBuffer buffer;
  std::uint32_t first = 0;
  for (const std::size_t count : {100U, 80U, 30'000U, 10U, 10U, 300U}) {
    Write(buffer, GetParam(), From(++first, count));
    EXPECT_EQ(Read(buffer.name(), count), From(first, count)) << count;
    EXPECT_LE(buffer.capacity_bytes(), std::max<std::size_t>(4 * 4 * count, 1600)) << "no more than four times that";
    buffer.Retire();
  }
}

TEST_P(StreamBufferIn, DoesNotChangeDataThatIsStillDrawn) {
  StreamBuffer buffer;
  constexpr std::size_t kCount = 1'000'000;
  std::vector<GlBuffer> copies;
  for (std::uint32_t i = 0; i < 8; ++i) {
    Write(buffer, GetParam(), From(i, kCount));
    copies.push_back(TakeCopy(buffer, kCount));
    buffer.Retire();
  }
  for (std::uint32_t i = 0; i < 8; ++i) EXPECT_EQ(Read(copies[i].name(), kCount), From(i, kCount));
}

TEST_P(StreamBufferIn, UsesNewMemoryWhileTheOldMayStillBeDrawn) {
  if (GetParam() != StreamBuffer::Way::kMapped) GTEST_SKIP() << "GL ensures this itself.";
  StreamBuffer never_drawn([](GLsync) { return false; });
  StreamBuffer never_retired;
  for (StreamBuffer* buffer : {&never_drawn, &never_retired}) {
    Write(*buffer, GetParam(), From(1, 100));
    for (std::uint32_t i = 2; i < 5; ++i) {
      const GLuint former = buffer->name();
      if (buffer == &never_drawn) buffer->Retire();
      Write(*buffer, GetParam(), From(i, 100));
      EXPECT_NE(buffer->name(), former);
      EXPECT_EQ(Read(buffer->name(), 100), From(i, 100));
    }
  }
}

TEST_P(StreamBufferIn, ReusesItsMemory) {
  StreamBuffer buffer;
  Write(buffer, GetParam(), From(0, 1000));
  const GLuint name = buffer.name();
  for (std::uint32_t i = 0; i < 5; ++i) {
    buffer.Retire();
    glFinish();
    Write(buffer, GetParam(), From(i, 900));
    EXPECT_EQ(buffer.name(), name);
    EXPECT_EQ(buffer.capacity_bytes(), 4000U);
  }
}

TEST_P(StreamBufferIn, CanChangeBetweenMappedAndCopied) {
  StreamBuffer buffer;
  for (const auto way : {GetParam(), StreamBuffer::Way::kCopied, GetParam(), StreamBuffer::Way::kCopied}) {
    Write(buffer, way, From(7, 50));
    EXPECT_EQ(Read(buffer.name(), 50), From(7, 50));
    buffer.Retire();
  }
}

}  // namespace
}  // namespace hgros::viewer
