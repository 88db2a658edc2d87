#include "ros/navigate/cmd_vel_mux_node.hpp"
#include "ros/program/run_node.hpp"

/// The program `cmd_vel_mux`: CmdVelMuxNode in a separate process, which stops the base when it ends. Exit
/// status 1 on bad parameters.
int main(int argc, char** argv) {
  return extperfc::ros_program::run_node<extperfc::ros_navigate::CmdVelMuxNode>(argc, argv, "cmd_vel_mux");
}
