#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "commands/commands.hpp"
#include "terminal/console.hpp"
#include "terminal/output_file.hpp"

namespace hgros::cli {
namespace {

// In file names and in texts, $NAME is the name of the package.
constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kFiles{{
    {"CMakeLists.txt", R"(cmake_minimum_required(VERSION 3.25)
project($NAME LANGUAGES CXX)
find_package(hgros REQUIRED)

hgros_add_messages($NAME_messages $NAME.proto)
hgros_add_components($NAME_components SOURCES limiter.cpp COMPONENTS $NAME/Limiter LINK $NAME_messages)

enable_testing()
add_executable(limiter_test limiter_test.cpp)
target_link_libraries(limiter_test PRIVATE hgros::hgros $NAME_messages)
add_test(NAME limiter_test COMMAND limiter_test)
)"},
    {"$NAME.proto", R"(syntax = "proto3";
package $NAME_messages;

message Speed {
  double mps = 1;  // m/s
}
)"},
    {"limiter.cpp", R"(// Passes the speeds that are wanted, but none above `max_mps`.
#include <algorithm>

#include <$NAME.pb.h>
#include <hgros/component/component.hpp>

class Limiter {
 public:
  explicit Limiter(hgros::Context& context) : context_(context), allowed_(context.Advertise<$NAME_messages::Speed>("allowed")) {
    context.Declare("max_mps", 0.5, {.description = "The largest speed, forward and back.", .unit = "m/s", .least = 0});
    context.FromAny<$NAME_messages::Speed>("wanted", hgros::Invoke::kSerial,
                                  [this](const $NAME_messages::Speed& wanted) { Limit(wanted); });
  }

 private:
  void Limit($NAME_messages::Speed speed) {
    const double max = context_.params().Get<double>("max_mps");
    speed.set_mps(std::clamp(speed.mps(), -max, max));
    (void)allowed_(speed);
  }

  hgros::Context& context_;
  hgros::Publisher<$NAME_messages::Speed> allowed_;
};
HGROS_COMPONENT(Limiter, "$NAME/Limiter")
)"},
    {"limiter_test.cpp", R"(// Tests Limiter without a robot, and without waiting.
#include "limiter.cpp"

#include <cstdio>

#include <hgros/testing/harness.hpp>

int main() {
  hgros::testing::Harness<Limiter> limiter({.params = "max_mps: 0.2"});
  $NAME_messages::Speed wanted;
  wanted.set_mps(3);
  limiter.Feed("wanted", wanted);
  const auto allowed = limiter.Take<$NAME_messages::Speed>("allowed");
  const bool limited = allowed.size() == 1 && allowed[0]->mps() == 0.2;
  std::puts(limited ? "3 m/s became 0.2 m/s" : "3 m/s did not become 0.2 m/s");
  return limited ? 0 : 1;
}
)"},
    {"robot.yaml", R"(components:
  limiter: {type: $NAME/Limiter, params: {max_mps: 1}}
)"},
}};

constexpr std::string_view kNextSteps = R"(Wrote a component, its message, a test and a robot file into $NAME. Next:
  cd $NAME
  cmake -B build && cmake --build build && ctest --test-dir build
  HGROS_COMPONENT_PATH=$PWD/build/share/hgros/components hgros run robot.yaml
  hgros pub wanted '{mps: 3}'  # In another terminal, like: hgros echo allowed
)";

class New final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"NAME", "", "Of the package and its folder, such as arm_driver", ValueKind::kName, {}, true},
                         name_);
  }
  [[nodiscard]] std::string Description() const override {
    return "Writes a package that builds into the new folder NAME: a component, its message, a test, a robot file, "
           "and CMake. Change the files as you like.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros new arm_driver", "Writes the package arm_driver into the folder arm_driver."},
            {"hgros new gripper", "Writes the package gripper."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  [[nodiscard]] std::string Filled(std::string_view pattern) const {
    std::string text(pattern);
    constexpr std::string_view kPlace = "$NAME";
    for (std::size_t at = 0; (at = text.find(kPlace, at)) != std::string::npos; at += name_.size()) {
      text.replace(at, kPlace.size(), name_);
    }
    return text;
  }

  std::string name_;
};

// What CMake and C++ reserve, such as "test" and "double", may be a name: all that they see has a word behind it.
int New::Run(Surroundings& surroundings) {
  const bool fits = name_[0] >= 'a' && name_[0] <= 'z' &&
                    name_.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
  if (!fits || name_ == "hgros") {
    throw UsageError("\"" + name_ + "\" cannot name a package. Use small letters, digits and '_', such as arm_driver" +
                     (fits ? ", and not the name of ours." : "."));
  }
  if (!std::filesystem::create_directory(name_)) {
    throw Error("The folder " + name_ + " is there already.", {}, "Choose another name, or remove it.");
  }
  for (const auto& [file, text] : kFiles) WriteTo(surroundings.console, name_ + "/" + Filled(file), Filled(text));
  surroundings.console.Write(Filled(kNextSteps));
  return kDone;
}

}  // namespace

std::unique_ptr<Command> MakeNew() { return std::make_unique<New>(); }

}  // namespace hgros::cli
