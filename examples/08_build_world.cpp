// Builds a world in a program, simulates the robot in it for two seconds, and looks where a ball went.
#include "extperfc/simulate/simulator.hpp"

#include "examples/example.hpp"

using namespace extperfc;

int main() {
  const std::filesystem::path root = EXTPERFC_SOURCE_DIR;
  auto world = examples::value_of(simulate::parse_world(R"(
name: hall
floor_plan: {min: [-5, -5], max: [5, 5]}
objects:
  - floor: {material: tiles}
)",
                                                        "hall"));
  simulate::BodySpec ball;
  ball.name = "ball";
  ball.mobility = simulate::Mobility::kLoose;
  ball.mass_kg = 0.2;
  ball.world_T_body = make_pose({1.5, 0.0, 1.0});
  Shape sphere;
  sphere.geometry = Sphere{0.1};
  ball.shapes = {sphere};
  world.bodies.push_back(ball);

  auto robot = examples::value_of(RobotModel::from_file(root / "urdf/mobile_baxter.urdf", root));
  simulate::SimulatorParams params;
  params.start_enabled = true;
  auto simulator = examples::value_of(simulate::Simulator::make(params, std::move(robot), std::move(world)));
  while (simulator->time_s() < 2.0) {
    simulator->command_base({0.2, 0.0, 0.0});  // [m/s], [m/s], [rad/s]
    simulator->step();
  }
  const auto now = simulator->snapshot();
  std::cout << "the robot drove to x " << simulator->base_state().truth.x << " m\n"
            << "the ball lies at " << now.world_T_body.back().translation().transpose() << " m\n";
}
