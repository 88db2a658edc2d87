#include "test/ros/robot/robot_test.hpp"

#include <stdexcept>

#include <ros/package.h>

namespace extperfc::ros_test {

namespace {

simulate::WorldSpec room_with_a_cube() {
  simulate::WorldSpec world;
  world.name = "room";
  simulate::BodySpec cube;
  cube.name = "cube";
  cube.mobility = simulate::Mobility::kLoose;
  cube.world_T_body.translation() = Eigen::Vector3d(4, 4, 1);
  cube.shapes.push_back({Box{{0.03, 0.03, 0.03}}, Pose::Identity(), {}});
  cube.mass_kg = 0.05;
  world.bodies.push_back(cube);
  return world;
}

std::unique_ptr<simulate::Simulator> make_simulator(bool dynamic) {
  static const auto kRobot = [] {
    const auto package = ros::package::getPath("extperfc");
    return RobotModel::from_file(package + "/urdf/mobile_baxter.urdf", package);
  }();
  if (!kRobot) throw std::runtime_error(kRobot.error().message);
  simulate::SimulatorParams params;
  params.bodies.dynamic = dynamic;
  if (!dynamic) params.bodies.gravity_m_s2 = 0;
  params.start_enabled = true;
  auto simulator = simulate::Simulator::make(params, *kRobot, room_with_a_cube());
  if (!simulator) throw std::runtime_error(simulator.error().message);
  return std::move(*simulator);
}

}  // namespace

RobotTest::RobotTest(bool dynamic)
    : host_(make_simulator(dynamic)),
      simulator_(host_.simulator()),
      interface_(handle_, host_, ros_params::RobotInterfaceParams{}) {
  host_.advance(0.05);
}

}  // namespace extperfc::ros_test
