#include "ros/program/run_node.hpp"

#include <csignal>

#include <ros/callback_queue.h>

namespace extperfc::ros_program {

namespace {

constexpr double kLookS = 0.2;  // between checks for the signal

volatile std::sig_atomic_t stop_asked = 0;

void on_signal(int /*signal*/) {
  stop_asked = 1;
}

}  // namespace

void init(int argc, char** argv, const char* name) {
  ros::init(argc, argv, name, ros::init_options::NoSigintHandler);
  (void)std::signal(SIGINT, on_signal);
  (void)std::signal(SIGTERM, on_signal);
}

void spin_until_signal() {
  while (ros::ok() && stop_asked == 0)
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(kLookS));
}

}  // namespace extperfc::ros_program
