#include "transport/shm/pair/pair_socket.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstring>
#include <random>
#include <string>
#include <thread>

#include "hgros/base/ids.hpp"
#include "hgros/base/system_limits.hpp"
#include "support/await.hpp"
#include "support/no_descriptors.hpp"

namespace hgros::shm {
namespace {

constexpr std::size_t kMaxFrame = 1 << 20;

struct Ends {
  Ends() {
    int fds[2];
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, fds), 0);
    raw = fds[0];
    here = std::make_unique<PairSocket>(std::make_shared<const Handle>(fds[0]), kMaxFrame);
    there = std::make_unique<PairSocket>(std::make_shared<const Handle>(fds[1]), kMaxFrame);
  }
  void Write(const std::string& bytes) const {
    ASSERT_EQ(write(raw, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  /// Sends until the next frame has come.
  [[nodiscard]] bool Arrives(PairSocket::Frame& frame) const {
    return test::Await([&] {
      (void)here->Flush();
      return there->Receive(frame) == PairSocket::Read::kFrame;
    });
  }
  int raw = -1;
  std::unique_ptr<PairSocket> here;
  std::unique_ptr<PairSocket> there;
};

std::string Header(std::uint32_t length, std::uint32_t handles) {
  std::string bytes(8, '\0');
  std::memcpy(bytes.data(), &length, 4);
  std::memcpy(bytes.data() + 4, &handles, 4);
  return bytes;
}

wire::PairMessage Payload(std::uint64_t number, std::size_t size) {
  wire::PairMessage message;
  message.mutable_payload()->set_number(number);
  message.mutable_payload()->set_data(std::string(size, static_cast<char>(number)));
  return message;
}

std::shared_ptr<const Handle> File() {
  return std::make_shared<const Handle>(MakeSegment("hgros-test", 4096, Access::kOwnerOnly, Pages::kOnTouch).handle);
}

/// Sends a frame without content that announces three descriptors, with `count` of them.
void SendDescriptors(int socket, std::size_t count) {
  std::string header = Header(0, 3);
  iovec part{header.data(), header.size()};
  std::vector<char> control(CMSG_SPACE(count * sizeof(int)));
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* const rights = CMSG_FIRSTHDR(&message);
  rights->cmsg_level = SOL_SOCKET;
  rights->cmsg_type = SCM_RIGHTS;
  rights->cmsg_len = CMSG_LEN(count * sizeof(int));
  const int standard = STDIN_FILENO;
  for (std::size_t i = 0; i < count; ++i) std::memcpy(CMSG_DATA(rights) + i * sizeof(int), &standard, sizeof(int));
  ASSERT_EQ(sendmsg(socket, &message, 0), static_cast<ssize_t>(header.size()));
}

TEST(ShmPairSocket, BlamesAPeerThatSendsMoreDescriptorsThanAFrameMayHave) {
  const Ends ends;
  const std::size_t most = 1000;
  const std::size_t before = FreeDescriptors(most);
  SendDescriptors(ends.raw, 200);
  PairSocket::Frame frame;
  EXPECT_EQ(ends.there->Receive(frame), PairSocket::Read::kFault);
  EXPECT_EQ(ends.there->fault(), "it sends too many descriptors at once");
  EXPECT_EQ(FreeDescriptors(most), before);
}

TEST(ShmPairSocket, TellsThatThisProcessHasNoRoomForDescriptors) {
  const Ends ends;
  PairSocket::Frame frame;
  for (const std::size_t left : {0U, 2U}) {
    SendDescriptors(ends.raw, 3);
    const test::NoDescriptors few(left);
    EXPECT_EQ(ends.there->Receive(frame), PairSocket::Read::kFrame);
    EXPECT_TRUE(frame.handles_lost);
    EXPECT_TRUE(frame.handles.empty());
  }
}

TEST(ShmPairSocket, FramesOfAllSizesArriveInOrderWithTheirDescriptors) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::minstd_rand random(seed);
    Ends ends;
    std::vector<std::pair<std::size_t, std::vector<ino_t>>> sent;
    std::size_t received = 0;
    PairSocket::Frame frame;
    for (int step = 0; step < 1000 || received < sent.size(); ++step) {
      if (step < 1000 && random() % 2 == 0) {
        const std::size_t size = random() % 10 == 0 ? random() % 700'000 : random() % 300;
        PairSocket::Handles handles;
        std::vector<ino_t> files;
        for (auto i = random() % 5; i > 0 && random() % 3 == 0; --i) {
          handles.push_back(File());
          struct stat status {};
          fstat(handles.back()->fd(), &status);
          files.push_back(status.st_ino);
        }
        sent.emplace_back(size, files);
        ends.here->Send(Payload(sent.size(), size), handles);
      } else {
        (void)ends.here->Flush();
        const auto read = ends.there->Receive(frame);
        if (read == PairSocket::Read::kNothing || read == PairSocket::Read::kMore) continue;
        ASSERT_EQ(read, PairSocket::Read::kFrame) << ends.there->fault();
        const auto& [size, files] = sent[received++];
        ASSERT_TRUE(frame.payload);
        ASSERT_EQ(frame.payload->number, received);
        ASSERT_EQ(AsText(frame.payload->data.bytes), std::string(size, static_cast<char>(received)));
        ASSERT_EQ(frame.handles.size(), files.size());
        for (std::size_t i = 0; i < files.size(); ++i) {
          struct stat status {};
          ASSERT_EQ(fstat(frame.handles[i].fd(), &status), 0);
          ASSERT_EQ(status.st_ino, files[i]);
        }
      }
    }
    EXPECT_TRUE(ends.here->all_sent());
  }
}

TEST(ShmPairSocket, ReportsAnInvalidFrameAndStillSeesTheEnd) {
  const std::pair<std::string, std::string> lies[] = {
      {Header(kMaxFrame + 1, 0), "a frame of"},
      {Header(0xffffffff, 0), "a frame of"},
      {Header(3, 5), "too many descriptors"},
      {Header(0, 1), "without its descriptors"},
      {Header(4, 0) + "\xff\xff\xff\xff", "does not parse"},
  };
  for (const auto& [bytes, fault] : lies) {
    Ends ends;
    ends.Write(bytes + std::string(100'000, 'x'));
    PairSocket::Frame frame;
    EXPECT_EQ(ends.there->Receive(frame), PairSocket::Read::kFault);
    EXPECT_NE(ends.there->fault().find(fault), std::string::npos) << ends.there->fault();
    EXPECT_EQ(ends.there->Receive(frame), PairSocket::Read::kNothing);
    ends.Write(Header(0, 0));
    EXPECT_EQ(ends.there->Receive(frame), PairSocket::Read::kNothing);
    ends.here.reset();
    EXPECT_EQ(ends.there->Receive(frame), PairSocket::Read::kClosed);
  }
}

TEST(ShmPairSocket, ALargeFrameIsReadInPieces) {
  Ends ends;
  ends.here->Send(Payload(1, 700'000));  // The socket accepts only a part of it.
  ASSERT_FALSE(ends.here->all_sent());
  PairSocket::Frame frame;
  EXPECT_EQ(ends.there->Receive(frame), PairSocket::Read::kMore);
  const std::uint64_t received = ends.there->received_bytes();
  EXPECT_GT(received, 0u);
  EXPECT_LT(received, 700'000u);
  ASSERT_TRUE(ends.Arrives(frame));
  ASSERT_TRUE(frame.payload);
  EXPECT_EQ(frame.payload->data.bytes.size(), 700'000u);
  EXPECT_GT(ends.there->received_bytes(), 700'000u);
}

TEST(ShmPairSocket, APayloadIsSentFromItsOwnMemoryAndArrivesBetweenOtherFrames) {
  for (const std::size_t size : {0u, 1u, 60'000u, 65'500u, 65'600u, 900'000u}) {
    SCOPED_TRACE(size);
    Ends ends;
    std::minstd_rand random(7);
    auto text = std::make_shared<std::string>(size, ' ');
    for (char& one : *text) one = static_cast<char>(random());
    const std::weak_ptr<const std::string> lives = text;
    ends.here->Send(Payload(1, 10));
    ends.here->SendPayload(77, 2, {AsBytes(*text), text});
    ends.here->Send(Payload(3, 10), {File()});
    const std::string expected = *std::exchange(text, nullptr);
    EXPECT_FALSE(lives.expired()) << "it is not copied";
    PairSocket::Frame frame;
    for (std::uint64_t number = 1; number <= 3; ++number) {
      ASSERT_TRUE(ends.Arrives(frame)) << ends.there->fault();
      ASSERT_TRUE(frame.payload);
      EXPECT_EQ(frame.payload->number, number);
      EXPECT_EQ(frame.handles.size(), number == 3 ? 1u : 0u);
      if (number != 2) continue;
      EXPECT_EQ(frame.payload->link, 77u);
      EXPECT_EQ(AsText(frame.payload->data.bytes), expected);
    }
    EXPECT_TRUE(ends.here->all_sent());
    EXPECT_TRUE(lives.expired());
    EXPECT_EQ(ends.here->sent_bytes(), ends.there->received_bytes());
  }
}

TEST(ShmPairSocket, OneFlushSendsOnlyAPartOfALargePayload) {
  constexpr std::size_t kSize = 64 << 20;
  const Ends ends;
  PairSocket& here = *ends.here;
  // A peer that reads as fast as it can: without a limit, one call would last until everything is sent.
  std::atomic<std::uint64_t> read_bytes{0};
  std::jthread reader([&](const std::stop_token& stop) {
    std::string into(1 << 20, ' ');
    while (!stop.stop_requested()) {
      const auto got = recv(ends.there->handle()->fd(), into.data(), into.size(), MSG_DONTWAIT);
      if (got > 0) read_bytes += static_cast<std::uint64_t>(got);
    }
  });
  auto text = std::make_shared<const std::string>(kSize, 'x');
  here.SendPayload(1, 1, {AsBytes(*text), text});
  std::uint64_t most = 0;
  ASSERT_TRUE(test::Await([&] {
    const std::uint64_t before = here.sent_bytes();
    (void)here.Flush();
    most = std::max(most, here.sent_bytes() - before);
    return here.all_sent();
  }));
  EXPECT_LT(most, kSize / 4);
  EXPECT_TRUE(test::Await([&] { return read_bytes == here.sent_bytes(); }));
}

TEST(ShmPairSocket, ATruncatedFrameEndsTheSocket) {
  Ends ends;
  ends.Write(Header(100, 0) + "half");
  PairSocket::Frame frame;
  EXPECT_EQ(ends.there->Receive(frame), PairSocket::Read::kNothing);
  ends.here.reset();
  EXPECT_EQ(ends.there->Receive(frame), PairSocket::Read::kClosed);
  EXPECT_EQ(ends.there->Receive(frame), PairSocket::Read::kClosed);
}

TEST(ShmPairSocket, SendingAfterThePeerHasGoneDropsEverything) {
  Ends ends;
  ends.there.reset();
  for (int i = 0; i < 100; ++i) ends.here->Send(Payload(1, 10'000));
  EXPECT_TRUE(ends.here->all_sent());
}

TEST(ShmPairSocket, ReportsTheEndOfTheProcessBehindAPlace) {
  const std::string place = "hgros-test-" + SessionId::Random().ToString();
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    std::string fault;
    const Handle listening = ListenAt(place, fault);
    (void)!write(ready[1], "x", 1);
    for (;;) pause();
  }
  char byte = 0;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  close(ready[0]);
  close(ready[1]);
  std::string fault;
  const PairSocket socket(std::make_shared<const Handle>(ConnectTo(place, fault)), kMaxFrame);
  const OtherSide other = OtherSideOf(*socket.handle());
  EXPECT_EQ(other.process, child);
  EXPECT_EQ(other.user, geteuid());
  const Handle process = WatchProcess(other.process);
  if (!process.valid()) GTEST_SKIP() << "this kernel has no pidfd";
  EXPECT_FALSE(HasEnded(process));
  kill(child, SIGKILL);
  EXPECT_TRUE(test::Await([&] { return HasEnded(process); }));
  EXPECT_EQ(waitpid(child, nullptr, 0), child);
}

TEST(ShmPairSocket, APlaceBelongsToOneSessionAndLeavesNoFile) {
  const std::string place = "hgros-test-" + SessionId::Random().ToString();
  std::string fault;
  {
    const Handle first = ListenAt(place, fault);
    EXPECT_TRUE(first.valid());
    EXPECT_FALSE(ListenAt(place, fault).valid());
    EXPECT_NE(fault.find(place), std::string::npos);
  }
  EXPECT_TRUE(ListenAt(place, fault).valid());
  EXPECT_FALSE(ListenAt("", fault).valid());
  EXPECT_FALSE(ListenAt(std::string(200, 'a'), fault).valid());
}

}  // namespace
}  // namespace hgros::shm
