#include "mapper_move.hpp"

#include <string>

#include "../app/await.hpp"
#include "../app/channels.hpp"

namespace slam2d {

void MoveMapper(std::uint64_t at, std::chrono::seconds patience, hgros::Session& session, SourceNode& source,
                MapperNode& mapper, RollCall& roll_call, Ending& ending, Console& console) {
  if (!source.WaitUntilHeld()) {
    if (!ending.token().stop_requested()) console.Say("The log ended before the mapper could move.");
    return;
  }
  if (!mapper.WaitFor(at)) return;

  const auto began = std::chrono::steady_clock::now();
  mapper.PublishState();
  session.SetClosed(kPreChannel, true);
  session.AllowPublishing(kPreChannel, true);
  session.AllowSubscribing(kNextChannel, true);

  const auto deadline = began + patience;
  const std::string successor = roll_call.WaitForSuccessor(at, deadline);
  // The mapper of this process still subscribes to the closed pre_channel. With its successor there are two
  // subscribers.
  const bool joined = !successor.empty() && AwaitUnlessStopped(ending.token(), deadline, [&](auto timeout) {
    return session.WaitForSubscribers(kPreChannel, 2, timeout);
  }) && AwaitUnlessStopped(ending.token(), deadline, [&](auto timeout) {
    return session.WaitForPublishers(kNextChannel, 1, timeout);
  });
  if (!joined) {
    ending.Fail("No process on standby took over the mapper within " + std::to_string(patience.count()) + " s.");
    return;
  }
  mapper.Retire();
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - began;
  console.Say("From scan " + std::to_string(at) + " on, the mapper runs in session " + successor + ". The move took " +
              std::to_string(static_cast<int>(took.count() + 0.5)) + " ms.");
  source.Release();
}

}  // namespace slam2d
