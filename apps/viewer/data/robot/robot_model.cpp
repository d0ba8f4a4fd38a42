#include "viewer/data/robot/robot_model.hpp"

#include <urdf_parser/urdf_parser.h>

namespace hgros::viewer {

std::shared_ptr<const urdf::ModelInterface> ReadRobotModel(const std::string& urdf) {
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(urdf);
  if (!model) return nullptr;
  return {model.get(), [model](const urdf::ModelInterface* /*model*/) {
            for (const auto& [name, link] : model->links_) {
              link->child_links.clear();
              link->child_joints.clear();
            }
          }};
}

}  // namespace hgros::viewer
