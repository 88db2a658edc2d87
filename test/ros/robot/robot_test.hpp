#pragma once

#include <functional>
#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <ros/node_handle.h>

#include "extperfc/simulate/simulator.hpp"

#include "ros/robot/robot_interface.hpp"
#include "test/ros/robot/stepped_host.hpp"
#include "test/ros/support/inbox.hpp"
#include "test/ros/support/wait.hpp"
#include "test/ros/support/watch.hpp"

namespace extperfc::ros_test {

using simulate::ArmValues;
using simulate::Side;

/// The robot in an empty room without gravity, enabled, with a small loose cube far away; its interface is
/// in the root namespace.
class RobotTest : public testing::Test {
 protected:
  /// `dynamic`: arms driven by motors, with gravity.
  explicit RobotTest(bool dynamic = false);

  /// Publishes and waits until it was handed to the simulation; then it counts in the next step.
  template <typename M>
  void send(const ros::Publisher& publisher, const M& message) {
    ASSERT_TRUE(wait_for([&] { return publisher.getNumSubscribers() > 0; })) << publisher.getTopic();
    const auto before = host_.posted();
    publisher.publish(message);
    ASSERT_TRUE(wait_for([&] { return host_.posted() > before; })) << publisher.getTopic();
  }
  /// Publishes without waiting for more than the listener.
  template <typename M>
  void send_in_vain(const ros::Publisher& publisher, const M& message) {
    ASSERT_TRUE(wait_for([&] { return publisher.getNumSubscribers() > 0; })) << publisher.getTopic();
    publisher.publish(message);
  }

  /// The next message that is published after this call.
  template <typename M>
  boost::shared_ptr<const M> next(Inbox<M>& inbox) {
    EXPECT_TRUE(wait_for([&] { return inbox.connected(); }));
    const auto before = inbox.count();
    EXPECT_TRUE(host_.advance_until([&] { return inbox.count() > before; }));
    const auto all = inbox.all();
    return all.empty() ? boost::make_shared<const M>() : all.back();
  }

  [[nodiscard]] ArmValues positions(Side side) { return simulator_.arm_state(side).position; }
  [[nodiscard]] double position(Side side, int joint) { return positions(side)[joint]; }
  [[nodiscard]] double velocity(Side side, int joint) { return simulator_.arm_state(side).velocity[joint]; }

  ros::NodeHandle handle_;
  SteppedHost host_;
  simulate::Simulator& simulator_;
  LogWatch log_;
  ros_robot::RobotInterface interface_;
};

}  // namespace extperfc::ros_test
