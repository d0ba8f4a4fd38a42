// Robot descriptions are in a separate library.
#include <hgros/tf/robot_description.hpp>

int main() {
  const auto robot = hgros::RobotDescription::FromText(
      R"(<robot name="cart"><link name="base"/><link name="laser"/>
         <joint name="mount" type="fixed"><parent link="base"/><child link="laser"/></joint></robot>)");
  hgros::TransformTree tree;
  if (!robot.SetFixed(tree)) return 1;
  return tree.Lookup("base", "laser") ? 0 : 1;
}
