#include "test/benchmark/sim/whole_robot.hpp"

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <thread>

#include <nav_msgs/Odometry.h>
#include <nodelet/loader.h>
#include <ros/node_handle.h>
#include <ros/param.h>
#include <ros/service.h>
#include <ros/spinner.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/PointCloud2.h>

#include "extperfc/SetRealTimeFactor.h"
#include "extperfc/base/stopwatch.hpp"

namespace extperfc::benchmark {
namespace {

constexpr double kStartDeadlineS = 30.0;
constexpr double kRgbdHz = 15.0;
constexpr double kSweepHz = 10.0;

/// Subscribes to everything, as consumers in the same manager do, and counts.
class Listeners {
 public:
  Listeners() {
    listen<sensor_msgs::Image>("camera/color/image_raw", images);
    listen<sensor_msgs::Image>("camera/aligned_depth_to_color/image_raw", depths);
    listen<sensor_msgs::PointCloud2>("velodyne_points", sweeps);
    listen<sensor_msgs::JointState>("robot/joint_states", others);
    listen<nav_msgs::Odometry>("odom", others);
    listen<sensor_msgs::Imu>("imu/data", others);
  }

  std::atomic<int> images{0};
  std::atomic<int> depths{0};
  std::atomic<int> sweeps{0};
  std::atomic<int> others{0};

 private:
  template <typename M>
  void listen(const std::string& topic, std::atomic<int>& count) {
    subscribers_.push_back(
        handle_.subscribe<M>(topic, 10, [&count](const boost::shared_ptr<const M>&) { ++count; }));
  }

  ros::NodeHandle handle_;
  std::vector<ros::Subscriber> subscribers_;
};

/// What a stretch of time cost.
struct Stretch {
  double wall_s{0};
  double simulated_s{0};
  double cpu_s{0};
  int images{0};
  int sweeps{0};

  [[nodiscard]] double factor() const { return simulated_s / wall_s; }
  [[nodiscard]] double cores() const { return cpu_s / wall_s; }
};

Stretch watch_for(double seconds, const Listeners* listeners) {
  const Stopwatch wall;
  const double cpu = process_cpu_seconds();
  const ros::Time simulated = ros::Time::now();
  const int images = listeners ? listeners->depths.load() : 0;
  const int sweeps = listeners ? listeners->sweeps.load() : 0;
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  Stretch stretch{wall.seconds(), (ros::Time::now() - simulated).toSec(), process_cpu_seconds() - cpu, 0, 0};
  if (listeners) {
    stretch.images = listeners->depths - images;
    stretch.sweeps = listeners->sweeps - sweeps;
  }
  return stretch;
}

Result<void> set_factor(double factor) {
  SetRealTimeFactor call;
  call.request.factor = factor;
  if (ros::service::call("sim/set_real_time_factor", call) && call.response.success != 0) return {};
  return fail(ErrorCode::kFailed, "the simulator does not take a real-time factor: " + call.response.message);
}

bool wait_until(const std::function<bool()>& condition) {
  const Stopwatch watch;
  while (!condition()) {
    if (!ros::ok() || watch.seconds() > kStartDeadlineS) return false;
    ros::WallDuration(0.02).sleep();
  }
  return true;
}

std::vector<Row> rows_of(const std::string& world, const Stretch& steady, const Stretch& fast,
                         const Stretch& idle, const Stretch& idle_fast) {
  const double cores = std::thread::hardware_concurrency();
  const std::string all = world + ", all sensors";
  const std::string none = world + ", no sensors";
  return {at_least(Row{all, "real-time factor, wanted 1", "", steady.factor(), 1.0, "real time"}, 0.99),
          at_least(Row{all, "RGB-D frames per simulated second", "Hz", steady.images / steady.simulated_s,
                       kRgbdHz, "sensor"},
                   0.97 * kRgbdHz),
          at_least(Row{all, "VLP-16 sweeps per simulated second", "Hz", steady.sweeps / steady.simulated_s,
                       kSweepHz, "sensor"},
                   0.97 * kSweepHz),
          Row{all, "CPU at real time", "cores", steady.cores(), cores, "machine"},
          at_least(Row{all, "CPU that is left of two cores", "cores", 2.0 - steady.cores()}, 0.5),
          Row{all, "real-time factor, as fast as possible, lockstep", "", fast.factor(), 1.0, "real time"},
          Row{none, "CPU at real time", "cores", idle.cores(), cores, "machine"},
          Row{none, "real-time factor, as fast as possible", "", idle_fast.factor(), 1.0, "real time"}};
}

/// Loads the nodelet and waits for its clock.
Result<void> start(nodelet::Loader& loader, const std::string& name, bool lockstep) {
  ros::param::set(name + "/time/lockstep", lockstep);
  if (!loader.load(name, "extperfc/simulator", {}, {}))
    return fail(ErrorCode::kFailed, "the nodelet simulator does not start; its message is above");
  if (!wait_until(
          [] { return ros::Time::isValid() && ros::service::exists("sim/set_real_time_factor", false); }))
    return fail(ErrorCode::kFailed, "the simulator publishes no clock");
  return {};
}

/// Alone, at real time and as fast as possible.
Result<std::array<Stretch, 2>> without_sensors(double seconds) {
  nodelet::Loader loader(false);
  if (auto started = start(loader, "/simulator", false); !started) return tl::unexpected(started.error());
  const Stretch steady = watch_for(seconds, nullptr);
  if (auto set = set_factor(0); !set) return tl::unexpected(set.error());
  const Stretch fast = watch_for(seconds / 3, nullptr);
  loader.clear();
  return std::array<Stretch, 2>{steady, fast};
}

/// With every sensor subscribed; as fast as possible in lockstep, so that no measurement is left out.
Result<Stretch> with_sensors(double seconds, bool as_fast_as_possible) {
  nodelet::Loader loader(false);
  if (auto started = start(loader, "/simulator", as_fast_as_possible); !started)
    return tl::unexpected(started.error());
  const Listeners listeners;
  if (!wait_until([&] { return listeners.depths > 0 && listeners.sweeps > 0 && listeners.images > 0; }))
    return fail(ErrorCode::kFailed, "the simulator's sensors send nothing");
  if (as_fast_as_possible)
    if (auto set = set_factor(0); !set) return tl::unexpected(set.error());
  const Stretch stretch = watch_for(seconds, &listeners);
  loader.clear();
  return stretch;
}

}  // namespace

void use_simulated_time() {
  ros::param::set("/use_sim_time", true);
}

Result<std::vector<Row>> whole_robot_rows(const std::string& world, double seconds) {
  ros::AsyncSpinner spinner(1);
  spinner.start();
  ros::param::set("/simulator/world", world);
  const auto alone = without_sensors(seconds);
  if (!alone) return tl::unexpected(alone.error());
  const auto steady = with_sensors(seconds, false);
  if (!steady) return tl::unexpected(steady.error());
  const auto fast = with_sensors(seconds / 3, true);
  if (!fast) return tl::unexpected(fast.error());
  return rows_of(world, *steady, *fast, (*alone)[0], (*alone)[1]);
}

}  // namespace extperfc::benchmark
