/* @{p}: a transmission of ros2_control whose velocities and efforts follow its position.
 * @{stamp}
 * SPDX-License-Identifier: MIT
 *
 * A handle's value is the coordinate's times its unit (metres, radians) and its actuator's mechanical reduction, or over its joint's
 * reduction and with the joint's offset; efforts are the other way, so that power is kept. Velocities and efforts are mapped at the
 * positions of the side from which they come; where that side has no position handles, at those of the last call. What has no
 * answer (a position out of reach, a singularity) is NaN, with the reason in status(). After configure() nothing allocates, waits or
 * throws, and every call ends after a bounded number of steps.
 */
#ifndef @{P}_TRANSMISSION_HPP
#define @{P}_TRANSMISSION_HPP

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "hardware_interface/types/hardware_interface_type_values.hpp"
#include "transmission_interface/exception.hpp"
#include "transmission_interface/transmission.hpp"

#include "@{p}.h"

namespace @{p}_transmission
{
constexpr std::size_t count = @{P}_JOINTS;
using names = std::array<std::string, count>;
using values = std::array<double, count>;

inline values all(double value)
{
  values found;
  found.fill(value);
  return found;
}

class Transmission : public transmission_interface::Transmission
{
public:
  explicit Transmission(
    const names & actuators = {@{actuator_names}}, const names & joints = {@{joint_names}},
    const values & actuator_reduction = all(1.0), const values & joint_reduction = all(1.0),
    const values & joint_offset = all(0.0))
  : actuator_{"actuator", actuators, {@{actuator_units}}, all(0.0)}, joint_{"joint", joints, {@{joint_units}}, joint_offset}
  {
    for (std::size_t i = 0; i < count; ++i)
    {
      actuator_.unit[i] *= actuator_reduction[i];
      joint_.unit[i] /= joint_reduction[i];
      if (!std::isnormal(actuator_.unit[i]) || !std::isnormal(joint_.unit[i]) || !std::isfinite(joint_offset[i]))
      {
        throw transmission_interface::Exception("Reductions must be finite and not zero, offsets finite.");
      }
    }
  }

  void configure(
    const std::vector<transmission_interface::JointHandle> & joints,
    const std::vector<transmission_interface::ActuatorHandle> & actuators) override
  {
    joint_.take(joints);
    actuator_.take(actuators);
    const auto both = [this](std::size_t kind) { return !joint_.handles[kind].empty() && !actuator_.handles[kind].empty(); };
    moves_ = both(velocity) || both(effort);
    if (!both(position) && !moves_)
    {
      throw transmission_interface::Exception("No interface has handles of all actuators and of all joints.");
    }
    if (moves_ && joint_.handles[position].empty() && actuator_.handles[position].empty())
    {
      throw transmission_interface::Exception("Velocities and efforts depend on the position: give position handles too.");
    }
  }

  void actuator_to_joint() override
  {
    if (!actuator_.handles[position].empty())
    {
      values motors = actuator_.read(position);
      values found = found_;
      status_ = solved(@{p}_track, @{p}_direct, motors, found);
      place(motors, found);
    }
    pass(actuator_, joint_, found_, jacobian_, inverse_);
  }

  void joint_to_actuator() override
  {
    if (!joint_.handles[position].empty())
    {
      values found = joint_.read(position);
      values motors = motors_;
      status_ = solved(@{p}_track_inverse, @{p}_inverse, found, motors);
      place(motors, found);
    }
    pass(joint_, actuator_, motors_, inverse_, jacobian_);
  }

  std::size_t num_actuators() const override { return count; }
  std::size_t num_joints() const override { return count; }

  /// What the last call came to: @{P}_OK, or why there are no values.
  @{p}_status status() const { return status_; }

private:
  using matrix = std::array<double, count * count>;
  enum kinds : std::size_t { position, velocity, effort };

  template <typename Handle> struct Side
  {
    const char * what;
    names name;
    values unit;
    values offset;
    std::array<std::vector<Handle>, 3> handles{};

    /// Handles by interface in the order of the names: all of them, or none.
    void take(const std::vector<Handle> & given)
    {
      const std::array<const char *, 3> interfaces{
        hardware_interface::HW_IF_POSITION, hardware_interface::HW_IF_VELOCITY, hardware_interface::HW_IF_EFFORT};
      for (std::size_t kind = 0; kind < interfaces.size(); ++kind)
      {
        handles[kind].clear();
        for (const auto & one : name)
        {
          for (const auto & handle : given)
          {
            if (handle && handle.get_prefix_name() == one && handle.get_interface_name() == interfaces[kind])
            {
              handles[kind].push_back(handle);
              break;
            }
          }
        }
        if (!handles[kind].empty() && handles[kind].size() != count)
        {
          std::string wanted;
          for (const auto & one : name) { wanted += " " + one; }
          throw transmission_interface::Exception(
            std::string(interfaces[kind]) + " has handles of some " + what + "s only; there are" + wanted + ".");
        }
      }
    }

    values read(std::size_t kind) const
    {
      values found;
      for (std::size_t i = 0; i < count; ++i)
      {
        const double value = handles[kind][i].get_value();
        found[i] = (kind == effort) ? value * unit[i] : (value - ((kind == position) ? offset[i] : 0.0)) / unit[i];
      }
      return found;
    }

    void write(std::size_t kind, const values & value)
    {
      for (std::size_t i = 0; i < count && !handles[kind].empty(); ++i)
      {
        handles[kind][i].set_value(
          (kind == effort) ? value[i] / unit[i] : value[i] * unit[i] + ((kind == position) ? offset[i] : 0.0));
      }
    }
  };

  /// From the last values by steps, and along the whole line where these are not enough.
  template <typename Track, typename Solve>
  static @{p}_status solved(Track track, Solve solve, const values & known, values & wanted)
  {
    @{p}_info info{};
    values near = wanted;
    for (int step = 0; step < 4; ++step)
    {
      if (track(known.data(), near.data(), &info) != @{P}_OK) { break; }
      if (info.residual <= @{P}_TOLERANCE) { wanted = near; return @{P}_OK; }
    }
    return solve(nullptr, known.data(), wanted.data(), wanted.data(), &info);
  }

  void place(const values & motors, const values & found)
  {
    if (status_ == @{P}_OK && moves_) { status_ = @{p}_jacobian(motors.data(), found.data(), jacobian_.data()); }
    if (status_ == @{P}_OK && moves_) { status_ = @{p}_inverse_jacobian(motors.data(), found.data(), inverse_.data()); }
    if (status_ == @{P}_OK) { motors_ = motors; found_ = found; }
  }

  /// `rates` maps velocities, `back` transposed maps efforts.
  template <typename From, typename To>
  void pass(From & from, To & to, const values & there, const matrix & rates, const matrix & back)
  {
    const bool known = (status_ == @{P}_OK);
    const auto none = std::numeric_limits<double>::quiet_NaN();
    if (!from.handles[position].empty()) { to.write(position, known ? there : all(none)); }
    for (const std::size_t kind : {std::size_t{velocity}, std::size_t{effort}})
    {
      if (from.handles[kind].empty()) { continue; }
      const values given = from.read(kind);
      values passed = all(known ? 0.0 : none);
      for (std::size_t i = 0; i < count; ++i)
      {
        for (std::size_t j = 0; j < count; ++j)
        {
          passed[i] += ((kind == velocity) ? rates[count * i + j] : back[count * j + i]) * given[j];
        }
      }
      to.write(kind, passed);
    }
  }

  Side<transmission_interface::ActuatorHandle> actuator_;
  Side<transmission_interface::JointHandle> joint_;
  values motors_{@{actuator_home}};
  values found_{@{joint_home}};
  matrix jacobian_{};
  matrix inverse_{};
  bool moves_ = false;
  @{p}_status status_ = @{P}_OK;
};
}  // namespace @{p}_transmission

#endif
