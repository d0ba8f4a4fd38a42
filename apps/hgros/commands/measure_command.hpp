#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "arguments/command.hpp"
#include "robot/arrivals.hpp"
#include "robot/histogram.hpp"
#include "robot/overview.hpp"
#include "robot/robot.hpp"
#include "terminal/records.hpp"

namespace hgros::cli {

/// What hz, bw and delay have in common: once a second a report on each channel, from the counters of its users, or
/// with --receive from the messages that arrive here.
class MeasureCommand : public Command {
 public:
  void Declare(Arguments& arguments) final;
  int Run(Surroundings& surroundings) final;

 protected:
  [[nodiscard]] bool exact() const noexcept { return robot_options_.style.exact; }

  /// The columns of a report; the first is the channel.
  [[nodiscard]] virtual std::vector<Column> CountedColumns() const = 0;
  /// Adds the records of a channel, if its counters are known.
  virtual void AddCounted(Console& console, Records& records, const AllCounters& counters,
                          const KnownChannel& channel) = 0;

  /// The same with --receive, behind the channel.
  [[nodiscard]] virtual std::vector<Column> ArrivedColumns() const = 0;
  [[nodiscard]] virtual std::vector<Cell> ArrivedCells(const Arrived& arrived) const = 0;
  /// The quantity of the histogram at the end.
  struct Quantity {
    std::string name;
    Unit unit;
    Measurements Arrived::*values;
  };
  [[nodiscard]] virtual Quantity Distribution() const = 0;

 private:
  [[nodiscard]] int Count(Robot& robot);
  [[nodiscard]] int Receive(Robot& robot) const;

  std::vector<std::string> channels_;
  std::optional<std::uint64_t> count_;
  bool receive_ = false;
  RobotOptions robot_options_;
};

}  // namespace hgros::cli
