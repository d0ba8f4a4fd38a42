#pragma once

#include <cstdint>
#include <functional>
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
  void Declare(Arguments& arguments) override;
  int Run(Surroundings& surroundings) override;

 protected:
  [[nodiscard]] bool exact() const noexcept { return robot_options_.style.exact; }
  [[nodiscard]] const std::vector<std::string>& channels() const noexcept { return channels_; }
  [[nodiscard]] bool receives() const noexcept { return receive_; }
  [[nodiscard]] const RobotOptions& robot_options() const noexcept { return robot_options_; }
  /// From the next second on calls `report` once a second, which returns whether there was anything to show. Returns
  /// the exit code.
  [[nodiscard]] int EachSecond(Robot& robot, const std::function<bool()>& report) const;

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
