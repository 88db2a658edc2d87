#include <gtest/gtest.h>
#include <ros/ros.h>

/// A test process is a ROS node: callbacks run in two threads of their own, so that tests can block and wait.
int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "test", ros::init_options::NoSigintHandler);
  const ros::NodeHandle keep_alive;
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
