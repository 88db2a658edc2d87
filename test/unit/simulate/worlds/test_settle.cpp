// Loose objects are in equilibrium where a world puts them: half a second of physics hardly moves them.

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/simulate/bodies.hpp"
#include "extperfc/simulate/random_world.hpp"

namespace extperfc::simulate {
namespace {

namespace fs = std::filesystem;

constexpr int kSteps = 120;       // of 1/240 s
constexpr double kMoved = 0.002;  // [m]
constexpr const char* kNoRobot = R"(<robot name="none"><link name="base"><inertial><mass value="1"/>
  <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>)";

void expect_rest(const WorldSpec& world) {
  const auto robot = RobotModel::from_urdf(kNoRobot, "");
  ASSERT_TRUE(robot) << robot.error().message;
  const auto bodies = Bodies::make({}, *robot, world, to_pose(world.robot_start), {});
  ASSERT_TRUE(bodies) << bodies.error().message;
  for (int i = 0; i < kSteps; ++i) (*bodies)->step();
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    if (world.bodies[i].mobility != Mobility::kLoose) continue;
    const Eigen::Vector3d moved = (*bodies)->world_T_body(static_cast<int>(i)).translation() -
                                  world.bodies[i].world_T_body.translation();
    EXPECT_LT(moved.norm(), kMoved) << world.name << ": " << world.bodies[i].name << " moved by "
                                    << moved.transpose();
  }
}

TEST(Settle, ShippedWorldsAreAtRest) {
  for (const char* name : {"lab", "bookshelf", "office"}) {
    const auto world =
        load_world(fs::path(EXTPERFC_SOURCE_DIR) / "config/worlds" / (std::string(name) + ".yaml"));
    ASSERT_TRUE(world) << world.error().message;
    expect_rest(*world);
  }
}

TEST(Settle, RandomTablesAreAtRest) {
  RandomWorldParams params;
  params.stacked = 0.3;
  for (std::uint64_t seed = 100; seed < 106; ++seed) {
    const auto world = random_world(params, seed);
    ASSERT_TRUE(world) << world.error().message;
    expect_rest(*world);
  }
}

}  // namespace
}  // namespace extperfc::simulate
