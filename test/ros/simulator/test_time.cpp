// Time: pause, single steps, reset, real-time factor; the same commands give the same states and images.
#include <cstring>

#include <geometry_msgs/Twist.h>
#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Float32.h>

#include "test/ros/simulator/simulator_test.hpp"
#include "test/ros/support/inbox.hpp"

namespace extperfc::ros_test {
namespace {

TEST_F(SimulatorTest, PausedTimeStandsStillAndIsKnownToLateListeners) {
  load(small_simulation());
  const auto stamp = step(12);
  const Inbox<rosgraph_msgs::Clock> clock("/clock");
  ASSERT_TRUE(clock.wait_for_count(1)) << "latched";
  EXPECT_EQ(clock.all().back()->clock, stamp);
  EXPECT_TRUE(never([&] { return clock.all().back()->clock != stamp; }, 0.3));
  pause(false);
  EXPECT_TRUE(wait_for([&] { return clock.all().back()->clock > stamp + ros::Duration(0.1); }));
  pause(true);
  const auto stopped = step(1);
  ASSERT_TRUE(wait_for([&] { return clock.all().back()->clock == stopped; }));
  EXPECT_TRUE(never([&] { return clock.all().back()->clock != stopped; }, 0.3));
}

TEST_F(SimulatorTest, StepsAreExact) {
  load(small_simulation());
  EXPECT_EQ(step(240), ros::Time(2.0));
  EXPECT_EQ(step(1), ros::Time(2.0 + 1.0 / 240.0));
}

TEST_F(SimulatorTest, StepsAreRefusedWithAReason) {
  load(small_simulation());
  StepSimulation::Request none;
  EXPECT_NE(call<StepSimulation>("sim/step", none).message.find("at least 1"), std::string::npos);
  pause(false);
  StepSimulation::Request one;
  one.steps = 1;
  const auto response = call<StepSimulation>("sim/step", one);
  EXPECT_FALSE(response.success);
  EXPECT_NE(response.message.find("pause it first"), std::string::npos) << response.message;
}

TEST_F(SimulatorTest, ResetGoesBackToTheStart) {
  const Inbox<rosgraph_msgs::Clock> clock("/clock");
  const Inbox<sensor_msgs::JointState> joints("robot/joint_states");
  load(small_simulation());
  ASSERT_TRUE(wait_for([&] { return joints.connected(); }));
  step(240);
  reset();
  EXPECT_TRUE(wait_for([&] { return !clock.all().empty() && clock.all().back()->clock == ros::Time(1.0); }));
  EXPECT_EQ(step(3), ros::Time(1.0 + 3.0 / 240.0));
}

TEST_F(SimulatorTest, KeepsTheRealTimeFactor) {
  const Inbox<rosgraph_msgs::Clock> clock("/clock");
  const Inbox<std_msgs::Float32> factor("sim/real_time_factor");
  load(with(small_simulation(), {{"time/real_time_factor", 0.2}, {"time/paused", false}}));
  ASSERT_TRUE(wait_for([&] { return !clock.all().empty() && clock.all().back()->clock > ros::Time(1.0); }));
  const auto began = ros::WallTime::now();
  const auto first = clock.all().back()->clock;
  ASSERT_TRUE(wait_for([&] { return clock.all().back()->clock - first > ros::Duration(0.3); }));
  // A busy machine may be slower, never faster.
  EXPECT_GT((ros::WallTime::now() - began).toSec(), 0.6 * 0.3 / 0.2);
  ASSERT_TRUE(wait_for([&] { return !factor.all().empty() && factor.all().back()->data > 0; }));
  EXPECT_LT(factor.all().back()->data, 0.25F);
}

TEST_F(SimulatorTest, TheFactorCanBeChangedAndIsChecked) {
  const Inbox<std_msgs::Float32> factor("sim/real_time_factor");
  load(with(small_simulation(), {{"time/paused", false}, {"time/real_time_factor", 0.1}}));
  SetRealTimeFactor::Request request;
  request.factor = -1;
  EXPECT_FALSE(call<SetRealTimeFactor>("sim/set_real_time_factor", request).success);
  request.factor = 0;
  EXPECT_TRUE(call<SetRealTimeFactor>("sim/set_real_time_factor", request).success);
  EXPECT_TRUE(wait_for([&] { return !factor.all().empty() && factor.all().back()->data > 0.2F; }))
      << "as fast as possible";
}

/// FNV-1a.
class Hash {
 public:
  void add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const std::uint8_t*>(data);
    for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ bytes[i]) * 1099511628211ULL;
  }
  template <typename T>
  void add(const std::vector<T>& values) {
    add(values.data(), values.size() * sizeof(T));
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_{14695981039346656037ULL};
};

struct Hashes {
  std::uint64_t joints{0}, images{0}, depths{0}, clouds{0};
  bool operator==(const Hashes& other) const {
    return joints == other.joints && images == other.images && depths == other.depths &&
           clouds == other.clouds;
  }
};

class Determinism : public SimulatorTest {
 protected:
  /// Drives in a circle for a second and hashes everything that was received.
  Hashes drive() {
    forget();
    geometry_msgs::Twist twist;
    twist.linear.x = 0.3;
    twist.angular.z = 0.5;
    const long before = received();
    command_.publish(twist);
    EXPECT_TRUE(wait_for([&] { return received() > before; })) << "the command must come before the steps";
    const auto end = step(240);  // whole seconds, so that every sensor has a last measurement then
    EXPECT_TRUE(joints_.wait_for_stamp(end) && color_.wait_for_stamp(end) && depth_.wait_for_stamp(end) &&
                cloud_.wait_for_stamp(end));
    return hashes();
  }

  /// A simulator whose base drives on for the whole of drive().
  void begin(int seed) {
    diagnostics_.clear();
    load(with(small_simulation(), {{"seed", seed}, {"base/command_timeout_s", 5.0}}));
    ASSERT_TRUE(connected());
  }

  void forget() {
    joints_.clear();
    color_.clear();
    depth_.clear();
    cloud_.clear();
  }

  [[nodiscard]] Hashes hashes() const {
    Hash joints;
    Hash color;
    Hash depth;
    Hash cloud;
    for (const auto& message : joints_.all()) {
      joints.add(message->position);
      joints.add(message->velocity);
    }
    for (const auto& message : color_.all()) color.add(message->data);
    for (const auto& message : depth_.all()) depth.add(message->data);
    for (const auto& message : cloud_.all()) cloud.add(message->data);
    return {joints.value(), color.value(), depth.value(), cloud.value()};
  }

  /// Commands that the base has taken.
  [[nodiscard]] long received() const {
    long count = 0;
    for (const auto& array : diagnostics_.all())
      for (const auto& status : array->status)
        for (const auto& pair : status.values)
          if (pair.key == "cmd_vel received") count = std::strtol(pair.value.c_str(), nullptr, 10);
    return count;
  }

  [[nodiscard]] bool connected() {
    return wait_for([this] {
      return joints_.connected() && color_.connected() && depth_.connected() && cloud_.connected() &&
             command_.getNumSubscribers() > 0;
    });
  }

  Inbox<diagnostic_msgs::DiagnosticArray> diagnostics_{"/diagnostics"};
  Inbox<sensor_msgs::JointState> joints_{"robot/joint_states"};
  Inbox<sensor_msgs::Image> color_{"camera/color/image_raw"};
  Inbox<sensor_msgs::Image> depth_{"camera/aligned_depth_to_color/image_raw"};
  Inbox<sensor_msgs::PointCloud2> cloud_{"velodyne_points"};
  ros::Publisher command_{ros::NodeHandle().advertise<geometry_msgs::Twist>("cmd_vel", 10)};
};

TEST_F(Determinism, TheSameCommandsGiveTheSameStatesAndImages) {
  ASSERT_NO_FATAL_FAILURE(begin(1));
  const auto first = drive();
  const auto elsewhere = drive();
  EXPECT_FALSE(first == elsewhere) << "it has driven on, so a hash that sees anything differs";
  reset();
  const auto again = drive();
  EXPECT_EQ(first.joints, again.joints);
  EXPECT_EQ(first.images, again.images);
  EXPECT_EQ(first.depths, again.depths);
  EXPECT_EQ(first.clouds, again.clouds);
  manager_.unload("/simulator");
  ASSERT_NO_FATAL_FAILURE(begin(1));
  EXPECT_TRUE(first == drive()) << "a new simulator";
  manager_.unload("/simulator");
  ASSERT_NO_FATAL_FAILURE(begin(2));
  const auto other_seed = drive();
  EXPECT_NE(first.images, other_seed.images);
  EXPECT_NE(first.clouds, other_seed.clouds);
}

}  // namespace
}  // namespace extperfc::ros_test
