// Whose velocity the base gets, as a nodelet.
#include <geometry_msgs/Twist.h>
#include <gtest/gtest.h>
#include <ros/param.h>
#include <std_msgs/Bool.h>

#include "test/ros/support/inbox.hpp"
#include "test/ros/support/manager.hpp"
#include "test/ros/support/watch.hpp"

namespace extperfc::ros_test {
namespace {

XmlRpc::XmlRpcValue sources() {
  XmlRpc::XmlRpcValue list;
  int count = 0;
  const auto add = [&](const char* name, const char* topic, int priority) {
    XmlRpc::XmlRpcValue source;
    source["name"] = std::string(name);
    source["topic"] = std::string(topic);
    source["priority"] = priority;
    source["timeout_s"] = 0.3;
    list[count++] = source;
  };
  add("joystick", "joy_vel", 2);
  add("navigator", "nav_vel", 1);
  return list;
}

class CmdVelMuxTest : public testing::Test {
 protected:
  void load() {
    ASSERT_TRUE(manager_.load("/mux", "cmd_vel_mux", {{"sources", sources()}})) << log_.text();
    ASSERT_TRUE(wait_for([&] {
      return joystick_.getNumSubscribers() > 0 && navigator_.getNumSubscribers() > 0 &&
             stop_.getNumSubscribers() > 0 && output_.connected();
    }));
  }
  static geometry_msgs::Twist ahead(double vx) {
    geometry_msgs::Twist message;
    message.linear.x = vx;
    return message;
  }
  [[nodiscard]] bool wait_for_velocity(double vx) const {
    return wait_for(
        [&] { return output_.count() > 0 && std::abs(output_.all().back()->linear.x - vx) < 1e-9; });
  }

  LogWatch log_;
  ros::NodeHandle handle_;
  ros::Publisher joystick_{handle_.advertise<geometry_msgs::Twist>("joy_vel", 1)};
  ros::Publisher navigator_{handle_.advertise<geometry_msgs::Twist>("nav_vel", 1)};
  ros::Publisher stop_{handle_.advertise<std_msgs::Bool>("e_stop", 1)};
  Inbox<geometry_msgs::Twist> output_{"cmd_vel"};
  Manager manager_;
};

TEST_F(CmdVelMuxTest, PrioritiesSilenceAndTheStop) {
  load();
  navigator_.publish(ahead(0.2));
  EXPECT_TRUE(wait_for_velocity(0.2));
  joystick_.publish(ahead(-0.1));
  EXPECT_TRUE(wait_for_velocity(-0.1));
  EXPECT_TRUE(wait_for_velocity(0.0)) << "all are silent";
  output_.clear();
  EXPECT_TRUE(never([&] { return output_.count() > 0; })) << "zero once";
  std_msgs::Bool on;
  on.data = 1;
  stop_.publish(on);
  EXPECT_TRUE(output_.wait_for_count(5)) << "zero all the time";
  joystick_.publish(ahead(0.3));
  EXPECT_TRUE(never([&] { return output_.all().back()->linear.x != 0; }));
}

TEST_F(CmdVelMuxTest, CommandsAreLimited) {
  load();
  navigator_.publish(ahead(50));
  EXPECT_TRUE(wait_for_velocity(0.8));
}

TEST_F(CmdVelMuxTest, BadSourcesAreRefusedAtOnce) {
  auto bad = sources();
  bad[0]["priority"] = 1;
  bad[1]["speed"] = 3.0;
  EXPECT_FALSE(manager_.load("/mux", "cmd_vel_mux", {{"sources", bad}, {"rate_hz", 0.0}}));
  EXPECT_TRUE(log_.wait("has the priority 1 of another one"));
  EXPECT_TRUE(log_.wait("speed: unknown"));
  EXPECT_TRUE(log_.wait("rate_hz = 0 is out of its range"));
}

}  // namespace
}  // namespace extperfc::ros_test
