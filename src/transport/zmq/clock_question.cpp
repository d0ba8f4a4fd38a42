#include "transport/zmq/clock_question.hpp"

#include <utility>

namespace hgros::zmq {

void ClockQuestion::Ask(wire::Heartbeat& heartbeat, Time now) {
  asked_ = now;
  heartbeat.set_asked_ns(now.nanoseconds);
}

std::optional<ClockExchange> ClockQuestion::Read(const wire::Heartbeat& heartbeat, Time got) {
  if (heartbeat.answer_to_ns() == 0 || heartbeat.answer_to_ns() != asked_.nanoseconds) return std::nullopt;
  return ClockExchange{std::exchange(asked_, Time{}), Time{heartbeat.received_ns()}, Time{heartbeat.answered_ns()},
                       got};
}

std::optional<wire::Heartbeat> AnswerTo(const wire::Heartbeat& heartbeat, Time received) {
  if (heartbeat.asked_ns() == 0) return std::nullopt;
  wire::Heartbeat answer;
  answer.set_answer_to_ns(heartbeat.asked_ns());
  answer.set_received_ns(received.nanoseconds);
  answer.set_answered_ns(received.nanoseconds);
  return answer;
}

}  // namespace hgros::zmq
