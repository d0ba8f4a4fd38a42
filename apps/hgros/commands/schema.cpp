#include <google/protobuf/descriptor.h>

#include <memory>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "messages/schema_text.hpp"
#include "messages/type_finder.hpp"
#include "robot/channel_type.hpp"
#include "robot/robot.hpp"
#include "terminal/records.hpp"

namespace hgros::cli {
namespace {

class Schema final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"TYPE", "", "A type such as foxglove.Log, or a channel", ValueKind::kType, {}, true}, name_);
    arguments.Flag("--template", template_, "A message as YAML with all fields, for `hgros pub`");
    types_.Declare(arguments);
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Shows the fields of a type, with all types in it, as in .proto files. The sessions that use a "
           "channel describe its type, so it need not be installed here, and the channel can be named itself.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros schema foxglove.Log", "Shows a type and the types in it."},
            {"hgros schema foxglove.Pose --template", "Writes a message to fill in and publish."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  void Show(Console& console, const google::protobuf::Descriptor& type) const;

  std::string name_;
  bool template_ = false;
  TypeOptions types_;
  RobotOptions options_;
};

void Schema::Show(Console& console, const google::protobuf::Descriptor& type) const {
  if (template_) return console.Write(TemplateText(type));
  if (!options_.style.json) return console.Write(ProtoText(type));
  Records records(console, options_.style,
                  {{"type", ""}, {"field", ""}, {"number", ""}, {"kind", ""}, {"repeated", ""}});
  for (const google::protobuf::FieldDescriptor* field : FieldsOf(type)) {
    records.Add({field->containing_type()->full_name(), field->name(), std::int64_t{field->number()}, KindOf(*field),
                 field->is_repeated()});
  }
  records.End();
}

int Schema::Run(Surroundings& surroundings) {
  if (template_ && options_.style.json) throw UsageError("--json and --template exclude each other.");
  const TypeFinder finder(types_);
  if (const google::protobuf::Descriptor* type = finder.Find(name_)) {
    Show(surroundings.console, *type);
    return kDone;
  }
  Robot robot(options_, surroundings);
  std::string channel;
  const auto is_known = [&] {
    channel = ChannelNamed(robot, name_).type_name.empty() ? ChannelOfType(robot, name_) : name_;
    return !channel.empty();
  };
  if (!AwaitChannels(robot, options_, "a channel with " + name_, is_known)) {
    std::string nearest = finder.Nearest(name_);
    if (nearest.empty()) nearest = NearestChannel(robot, name_);
    options_.GiveUp("There is no channel and no known type " + name_ + "." +
                    (nearest.empty() ? " Give the type's file with --proto, or the folder of its file with -I."
                                     : " Did you mean " + nearest + "?"));
  }
  Show(surroundings.console, TypeOfChannel(robot, options_, finder, channel, {}).type->descriptor());
  return kDone;
}

}  // namespace

std::unique_ptr<Command> MakeSchema() { return std::make_unique<Schema>(); }

}  // namespace hgros::cli
