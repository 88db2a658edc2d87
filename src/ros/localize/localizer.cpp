#include "ros/localize/localizer_node.hpp"
#include "ros/program/run_node.hpp"

/// The program `localizer`: LocalizerNode in a separate process, as amcl runs; it stores its pose when it
/// ends. Exit status 1 on bad parameters.
int main(int argc, char** argv) {
  return extperfc::ros_program::run_node<extperfc::ros_localize::LocalizerNode>(argc, argv, "localizer");
}
