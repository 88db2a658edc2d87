#include <cerrno>
#include <csignal>
#include <ctime>
#include <exception>

#include <ros/ros.h>
#include <semaphore.h>
#include <sys/resource.h>
#include <unistd.h>

#include "ros/params/translator_params.hpp"
#include "ros/translate/translator_node.hpp"

/// The program `translator`: joins two masters. See TranslatorNode.
namespace {

using extperfc::ros_params::load_translator_params;
using extperfc::ros_translate::TranslatorNode;

/// roscpp's farewell to a master that is gone may hang on a network that swallows packets; nothing of ours is
/// left then, so the program ends.
constexpr unsigned kFarewellS = 5;
/// Between looks whether `rosnode kill` or a node of the same name ended this one.
constexpr long kLookNs = 500'000'000;

/// Posted by SIGINT and SIGTERM. A signal handler reaches nothing but what lives as long as the program.
sem_t& stop_asked() {
  static sem_t semaphore = [] {
    sem_t made;
    (void)sem_init(&made, 0, 0);
    return made;
  }();
  return semaphore;
}

void on_signal(int /*signal*/) {
  (void)sem_post(&stop_asked());
}

void on_alarm(int /*signal*/) {
  _exit(0);
}

/// From now on, signals end the program in order; before, they end it at once.
void handle_signals() {
  (void)stop_asked();
  struct sigaction action {};
  action.sa_handler = on_signal;
  for (const int signal : {SIGINT, SIGTERM}) (void)sigaction(signal, &action, nullptr);
}

void wait_for_end() {
  while (ros::ok()) {
    timespec deadline{};
    (void)clock_gettime(CLOCK_REALTIME, &deadline);
    deadline.tv_nsec += kLookNs;
    deadline.tv_sec += deadline.tv_nsec / 1'000'000'000;
    deadline.tv_nsec %= 1'000'000'000;
    if (sem_timedwait(&stop_asked(), &deadline) == 0) return;
  }
}

/// Each topic takes a connection on either side: 500 topics are more than the usual 1024 descriptors.
void allow_many_connections() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  (void)setrlimit(RLIMIT_NOFILE, &limit);
}

int run() {
  allow_many_connections();
  const ros::NodeHandle handle;
  const ros::NodeHandle private_handle("~");
  auto params = load_translator_params(private_handle, ros::this_node::getName());
  auto node = params ? TranslatorNode::make(handle, private_handle, *params) : tl::unexpected(params.error());
  if (!node) {
    ROS_FATAL("%s", node.error().message.c_str());
    return 1;
  }
  handle_signals();
  (*node)->start();
  ros::AsyncSpinner spinner(2);  // a report must not wait for rules that are read again
  spinner.start();
  ROS_INFO("bridging %s (robot) and %s (workstation)", params->bridge.sides[0].peer.master_uri.c_str(),
           params->bridge.sides[1].peer.master_uri.c_str());
  wait_for_end();
  (*node)->shut_down();
  (void)std::signal(SIGALRM, on_alarm);
  (void)alarm(kFarewellS);
  spinner.stop();
  node->reset();
  ros::shutdown();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    ros::init(argc, argv, "translator", ros::init_options::NoSigintHandler);
    return run();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
}
