#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "remote/far_end.hpp"

namespace hgros::cli {
namespace {

class Hosted final : public Command {
 public:
  void Declare(Arguments& /*arguments*/) override {}
  [[nodiscard]] std::string Description() const override {
    return "What `hgros run` starts over ssh on another host: a process or program of a robot.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros __hosted > reports", "Takes orders from standard input, and writes its reports into a file."},
            {"hgros __hosted | wc -c", "Counts the bytes of its reports."}};
  }
  int Run(Surroundings& surroundings) override { return FarEnd(surroundings.pause).Run(); }
};

}  // namespace

std::unique_ptr<Command> MakeHosted() { return std::make_unique<Hosted>(); }

}  // namespace hgros::cli
