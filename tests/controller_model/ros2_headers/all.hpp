// Stand-ins for what the controller uses of ROS 2 Jazzy, as its headers declare it. No behaviour.
#ifndef ALL_HPP
#define ALL_HPP
#include <array>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace rclcpp
{
class Time {};
class Duration { public: double seconds() const { return 0.0; } };
class Logger {};
class SystemDefaultsQoS {};
template <class Message> class Subscription { public: using SharedPtr = std::shared_ptr<Subscription>; };
template <class Message> class Publisher { public: using SharedPtr = std::shared_ptr<Publisher>; };
class Parameter
{
public:
  std::vector<std::string> as_string_array() const { return {}; }
  double as_double() const { return 0.0; }
  std::int64_t as_int() const { return 0; }
  bool as_bool() const { return false; }
  std::string as_string() const { return {}; }
};
}  // namespace rclcpp
#define RCLCPP_ERROR(logger, ...) do { (void)(logger); std::printf(__VA_ARGS__); } while (false)

namespace rclcpp_lifecycle
{
class State {};
class LifecycleNode
{
public:
  rclcpp::Parameter get_parameter(const std::string &) const { return {}; }
  rclcpp::Logger get_logger() const { return {}; }
  const char * get_name() const { return ""; }
  template <class Message, class Call>
  typename rclcpp::Subscription<Message>::SharedPtr create_subscription(const std::string &, const rclcpp::SystemDefaultsQoS &, Call && call)
  {
    std::function<void(std::shared_ptr<Message>)> held = call;
    (void)held;
    return {};
  }
  template <class Message>
  typename rclcpp::Publisher<Message>::SharedPtr create_publisher(const std::string &, const rclcpp::SystemDefaultsQoS &)
  {
    return {};
  }
};
}  // namespace rclcpp_lifecycle

namespace hardware_interface
{
constexpr char HW_IF_POSITION[] = "position";
class CommandInterface
{
public:
  CommandInterface(const std::string &, const std::string &, double *) {}
  [[nodiscard]] bool set_value(double) { return true; }
};
class LoanedCommandInterface { public: [[nodiscard]] bool set_value(double) { return true; } };
class LoanedStateInterface { public: double get_value() const { return 0.0; } };
}  // namespace hardware_interface

namespace controller_interface
{
enum class return_type { OK, ERROR };
enum class interface_configuration_type { ALL, INDIVIDUAL, NONE };
enum class CallbackReturn { SUCCESS, FAILURE, ERROR };
struct InterfaceConfiguration { interface_configuration_type type; std::vector<std::string> names; };
class ChainableControllerInterface
{
public:
  virtual ~ChainableControllerInterface() = default;
  virtual CallbackReturn on_init() = 0;
  virtual InterfaceConfiguration command_interface_configuration() const = 0;
  virtual InterfaceConfiguration state_interface_configuration() const = 0;
  virtual CallbackReturn on_configure(const rclcpp_lifecycle::State &) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_activate(const rclcpp_lifecycle::State &) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_deactivate(const rclcpp_lifecycle::State &) { return CallbackReturn::SUCCESS; }
  virtual bool on_set_chained_mode(bool) { return true; }

protected:
  virtual std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() { return {}; }
  virtual return_type update_reference_from_subscribers(const rclcpp::Time &, const rclcpp::Duration &) = 0;
  virtual return_type update_and_write_commands(const rclcpp::Time &, const rclcpp::Duration &) = 0;
  template <class Value> void auto_declare(const std::string &, const Value &) {}
  std::shared_ptr<rclcpp_lifecycle::LifecycleNode> get_node() const { return {}; }
  std::vector<double> reference_interfaces_;
  std::vector<hardware_interface::LoanedCommandInterface> command_interfaces_;
  std::vector<hardware_interface::LoanedStateInterface> state_interfaces_;
};
}  // namespace controller_interface

namespace geometry_msgs::msg
{
struct PoseWithCovarianceStamped
{
  struct { rclcpp::Time stamp; std::string frame_id; } header;
  struct
  {
    struct { struct { double x, y, z; } position; struct { double x, y, z, w; } orientation; } pose;
    std::array<double, 36> covariance;
  } pose;
};
}  // namespace geometry_msgs::msg
namespace std_msgs::msg
{
struct Float64MultiArray { using SharedPtr = std::shared_ptr<Float64MultiArray>; std::vector<double> data; };
}  // namespace std_msgs::msg

namespace realtime_tools
{
template <class Value> class RealtimeBuffer
{
public:
  void writeFromNonRT(const Value & value) { held_ = value; }
  Value * readFromRT() { return &held_; }

private:
  Value held_{};
};
template <class Message> class RealtimePublisher
{
public:
  explicit RealtimePublisher(std::shared_ptr<rclcpp::Publisher<Message>>) {}
  bool trylock() { return true; }
  void unlockAndPublish() {}
  Message msg_{};
};
}  // namespace realtime_tools
#define PLUGINLIB_EXPORT_CLASS(derived, base) std::unique_ptr<base> lm_made() { return std::make_unique<derived>(); }
#endif
