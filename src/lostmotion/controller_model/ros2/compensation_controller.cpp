// A chainable controller between a trajectory and the position interfaces of the hardware: it sends the joint values whose tool is expected where the
// trajectory wants it. Every array is allocated before it runs; an update neither logs nor allocates nor waits.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "controller_interface/chainable_controller_interface.hpp"
#include "geometry_msgs/msg/pose_with_covariance_stamped.hpp"
#include "hardware_interface/types/hardware_interface_type_values.hpp"
#include "lm_core.h"
#include "pluginlib/class_list_macros.hpp"
#include "rclcpp/rclcpp.hpp"
#include "rclcpp_lifecycle/state.hpp"
#include "realtime_tools/realtime_buffer.hpp"
#include "realtime_tools/realtime_publisher.hpp"
#include "std_msgs/msg/float64_multi_array.hpp"

namespace lostmotion_controller
{
using controller_interface::CallbackReturn;
using controller_interface::InterfaceConfiguration;
using controller_interface::interface_configuration_type;
using controller_interface::return_type;
using geometry_msgs::msg::PoseWithCovarianceStamped;
using std_msgs::msg::Float64MultiArray;
using Joints = std::array<double, LM_JOINTS>;
using Load = std::array<double, 10>;

class CompensationController : public controller_interface::ChainableControllerInterface
{
public:
  CallbackReturn on_init() override
  {
    auto_declare<std::vector<std::string>>("joints", {});
    auto_declare<double>("reversal", 0.002);
    auto_declare<double>("largest_rate", 0.05);
    auto_declare<int>("passes", 1);
    auto_declare<bool>("whole_pose", false);
    auto_declare<std::string>("frame", "base_link");
    return CallbackReturn::SUCCESS;
  }

  InterfaceConfiguration command_interface_configuration() const override
  {
    return {interface_configuration_type::INDIVIDUAL, interfaces()};
  }

  InterfaceConfiguration state_interface_configuration() const override
  {
    return {interface_configuration_type::INDIVIDUAL, interfaces()};
  }

  CallbackReturn on_configure(const rclcpp_lifecycle::State &) override
  {
    joints_ = get_node()->get_parameter("joints").as_string_array();
    reversal_ = get_node()->get_parameter("reversal").as_double();
    largest_rate_ = get_node()->get_parameter("largest_rate").as_double();
    if (joints_.size() != LM_JOINTS) {
      RCLCPP_ERROR(get_node()->get_logger(), "'joints' has %zu names; the model has %d", joints_.size(), LM_JOINTS);
      return CallbackReturn::ERROR;
    }
    for (std::size_t k = 0; k < LM_JOINTS; k++) {
      if (joints_[k] != lm_joint_names[k]) {
        RCLCPP_ERROR(get_node()->get_logger(), "joint %zu is '%s'; in the model it is '%s'", k, joints_[k].c_str(), lm_joint_names[k]);
        return CallbackReturn::ERROR;
      }
    }
    if (lm_self_test() != 0) {
      RCLCPP_ERROR(get_node()->get_logger(), "the self test of the model fails on this machine");
      return CallbackReturn::ERROR;
    }
    lm_default_options(&options_);
    options_.passes = static_cast<int>(get_node()->get_parameter("passes").as_int());
    options_.whole_pose = get_node()->get_parameter("whole_pose").as_bool() ? 1 : 0;
    if (options_.passes != 1 && options_.passes != 2) {
      RCLCPP_ERROR(get_node()->get_logger(), "'passes' is %d; expected 1 or 2", options_.passes);
      return CallbackReturn::ERROR;
    }
    lm_defaults(&input_);
    Load load;
    std::copy(std::begin(input_.load), std::end(input_.load), load.begin());
    load_.writeFromNonRT(load);
    // mass, centre of mass (3), process force (3) and moment (3), in the axes of the tool
    payload_ = get_node()->create_subscription<Float64MultiArray>(
      "~/payload", rclcpp::SystemDefaultsQoS(), [this](const Float64MultiArray::SharedPtr message) {
        Load given;
        if (message->data.size() == given.size()) {
          std::copy(message->data.begin(), message->data.end(), given.begin());
          load_.writeFromNonRT(given);
        }
      });
    auto topic = get_node()->create_publisher<PoseWithCovarianceStamped>("~/tool", rclcpp::SystemDefaultsQoS());
    tool_ = std::make_unique<realtime_tools::RealtimePublisher<PoseWithCovarianceStamped>>(topic);
    tool_->msg_.header.frame_id = get_node()->get_parameter("frame").as_string();
    return CallbackReturn::SUCCESS;
  }

  CallbackReturn on_activate(const rclcpp_lifecycle::State &) override
  {
    for (std::size_t k = 0; k < LM_JOINTS; k++) {
      const double at = state_interfaces_[k].get_value();
      reference_interfaces_[k] = at;
      input_.q[k] = at;
      turned_[k] = at;
      side_[k] = 0.0;
      correction_[k] = 0.0;
    }
    return CallbackReturn::SUCCESS;
  }

  CallbackReturn on_deactivate(const rclcpp_lifecycle::State &) override
  {
    return CallbackReturn::SUCCESS;
  }

  bool on_set_chained_mode(bool) override
  {
    return true;
  }

protected:
  std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() override
  {
    reference_interfaces_.assign(LM_JOINTS, 0.0);
    std::vector<hardware_interface::CommandInterface> out;
    out.reserve(LM_JOINTS);
    for (std::size_t k = 0; k < LM_JOINTS; k++) {
      out.emplace_back(get_node()->get_name(), joints_[k] + "/" + hardware_interface::HW_IF_POSITION, &reference_interfaces_[k]);
    }
    return out;
  }

  return_type update_reference_from_subscribers(const rclcpp::Time &, const rclcpp::Duration &) override
  {
    return return_type::OK;  // the references of an unchained controller stay as they are
  }

  return_type update_and_write_commands(const rclcpp::Time & time, const rclcpp::Duration & period) override
  {
    const Load & load = *load_.readFromRT();
    std::copy(load.begin(), load.end(), std::begin(input_.load));
    for (std::size_t k = 0; k < LM_JOINTS; k++) {
      // a reference that is no number, as before the first command, leaves the joint where it was sent last
      input_.q[k] = std::isfinite(reference_interfaces_[k]) ? reference_interfaces_[k] : input_.q[k];
      input_.side[k] = last_motion(k);
    }
    const int status = lm_compensate(&input_, &options_, &output_, &command_);
    const bool valid = status == LM_OK || status == LM_SINGULAR;
    const double most = largest_rate_ * period.seconds();
    for (std::size_t k = 0; k < LM_JOINTS; k++) {
      // without an answer the correction fades to zero: the arm goes on as without this controller
      const double wanted = valid ? command_.q[k] - input_.q[k] : 0.0;
      correction_[k] += std::clamp(wanted - correction_[k], -most, most);
      (void)command_interfaces_[k].set_value(input_.q[k] + correction_[k]);
    }
    publish(time, valid);
    return return_type::OK;
  }

private:
  std::vector<std::string> interfaces() const
  {
    std::vector<std::string> out;
    for (const auto & joint : get_node()->get_parameter("joints").as_string_array()) {
      out.push_back(joint + "/" + hardware_interface::HW_IF_POSITION);
    }
    return out;
  }

  // The sign of the last commanded motion. It changes only where the command has turned back far enough; the measured velocity would chatter.
  double last_motion(std::size_t k)
  {
    const double at = input_.q[k];
    if ((at - turned_[k]) * side_[k] > 0.0) {
      turned_[k] = at;
    } else if (std::abs(at - turned_[k]) > reversal_) {
      side_[k] = at > turned_[k] ? 1.0 : -1.0;
      turned_[k] = at;
    }
    return side_[k];
  }

  void publish(const rclcpp::Time & time, bool valid)
  {
    if (!valid || !tool_->trylock()) {
      return;
    }
    auto & message = tool_->msg_;
    message.header.stamp = time;
    message.pose.pose.position.x = output_.point[0];
    message.pose.pose.position.y = output_.point[1];
    message.pose.pose.position.z = output_.point[2];
    const double * turn = output_.turn;
    // where the rotation is near half a turn, w is small and its sign is open: the largest component is found first
    const double squares[4] = {
      1 + turn[0] + turn[4] + turn[8], 1 + turn[0] - turn[4] - turn[8], 1 - turn[0] + turn[4] - turn[8], 1 - turn[0] - turn[4] + turn[8]};
    const auto largest = std::max_element(std::begin(squares), std::end(squares)) - std::begin(squares);
    const double twice = 2 * std::sqrt(squares[largest]);
    const double odd[3] = {turn[7] - turn[5], turn[2] - turn[6], turn[3] - turn[1]};
    const double even[3] = {turn[7] + turn[5], turn[2] + turn[6], turn[3] + turn[1]};  // yz, zx, xy
    std::array<double, 4> quaternion{};                                                // w x y z
    quaternion[static_cast<std::size_t>(largest)] = twice / 4;
    for (std::size_t k = 0; k < 3; k++) {
      if (largest == 0) {
        quaternion[k + 1] = odd[k] / twice;
      } else if (static_cast<std::size_t>(largest) == k + 1) {
        quaternion[0] = odd[k] / twice;
      } else {
        quaternion[k + 1] = even[3 - k - (static_cast<std::size_t>(largest) - 1)] / twice;
      }
    }
    message.pose.pose.orientation.w = quaternion[0];
    message.pose.pose.orientation.x = quaternion[1];
    message.pose.pose.orientation.y = quaternion[2];
    message.pose.pose.orientation.z = quaternion[3];
    const double * c = output_.covariance;
    const double rows[9] = {c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5]};
    for (std::size_t row = 0; row < 3; row++) {
      for (std::size_t column = 0; column < 3; column++) {
        message.pose.covariance[6 * row + column] = rows[3 * row + column];  // of the position; that of the rotation is not in the model
      }
    }
    tool_->unlockAndPublish();
  }

  std::vector<std::string> joints_;
  double reversal_ = 0.0;
  double largest_rate_ = 0.0;
  Joints turned_{};
  Joints side_{};
  Joints correction_{};
  lm_options options_{};
  lm_input input_{};
  lm_output output_{};
  lm_command command_{};
  realtime_tools::RealtimeBuffer<Load> load_;
  rclcpp::Subscription<Float64MultiArray>::SharedPtr payload_;
  std::unique_ptr<realtime_tools::RealtimePublisher<PoseWithCovarianceStamped>> tool_;
};
}  // namespace lostmotion_controller

PLUGINLIB_EXPORT_CLASS(lostmotion_controller::CompensationController, controller_interface::ChainableControllerInterface)
