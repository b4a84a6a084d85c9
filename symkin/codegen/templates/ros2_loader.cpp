// @{stamp}
// SPDX-License-Identifier: MIT
#include <exception>
#include <memory>

#include "hardware_interface/hardware_info.hpp"
#include "pluginlib/class_list_macros.hpp"
#include "rclcpp/logging.hpp"
#include "transmission_interface/transmission_loader.hpp"

#include "@{p}_transmission.hpp"

namespace @{p}_transmission
{
class Loader : public transmission_interface::TransmissionLoader
{
public:
  std::shared_ptr<transmission_interface::Transmission> load(
    const hardware_interface::TransmissionInfo & info) override
  {
    try
    {
      names actuators, joints;
      values actuator_reduction, joint_reduction, offset;
      for (std::size_t i = 0; i < count; ++i)
      {
        actuators[i] = info.actuators.at(i).name;
        actuator_reduction[i] = info.actuators.at(i).mechanical_reduction;
        joints[i] = info.joints.at(i).name;
        joint_reduction[i] = info.joints.at(i).mechanical_reduction;
        offset[i] = info.joints.at(i).offset;
      }
      return std::make_shared<Transmission>(actuators, joints, actuator_reduction, joint_reduction, offset);
    }
    catch (const std::exception & error)
    {
      RCLCPP_ERROR(rclcpp::get_logger("@{package}"), "Failed to construct transmission: %s", error.what());
      return nullptr;
    }
  }
};
}  // namespace @{p}_transmission

PLUGINLIB_EXPORT_CLASS(@{p}_transmission::Loader, transmission_interface::TransmissionLoader)
