// A simulator that cannot work refuses to load, and says everything that is wrong in one message.
#include <cstdlib>
#include <fstream>

#include <ros/package.h>

#include "ros/params/simulator_params.hpp"
#include "test/ros/simulator/simulator_test.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::ros_test {
namespace {

class Refusals : public SimulatorTest {
 protected:
  void expect_refusal(const Params& params, const std::vector<std::string>& texts) {
    EXPECT_FALSE(manager_.load("/simulator", "simulator", with(small_simulation(), params)));
    ASSERT_TRUE(log_.wait(texts.front())) << log_.text();
    for (const auto& text : texts)
      EXPECT_NE(log_.text().find(text), std::string::npos) << text << "\n" << log_.text();
    EXPECT_EQ(log_.count(texts.front()), 1U) << "once is enough:\n" << log_.text();
  }
};

TEST_F(Refusals, EveryBadParameterIsNamedAtOnce) {
  expect_refusal({{"camera/width", 5},
                  {"camera/depth_encoding", std::string("64FC1")},
                  {"lidar/rotation_hz", 99.0},
                  {"physics/step_hz", std::string("fast")},
                  {"base/colour", std::string("red")},
                  {"robot/feedback_rate_hz", -1.0},
                  {"arms/start_pose", std::string("handstand")},
                  {"speed", 3}},
                 {"camera/width = 5 is out of its range [16, 4096]", "'64FC1' is unknown: use 16UC1 or 32FC1",
                  "lidar/rotation_hz = 99 is out of its range [5, 20]", "physics/step_hz must be a number",
                  "base/colour is not a parameter", "robot/feedback_rate_hz = -1",
                  "'handstand' is unknown: use untuck, tuck or neutral", "speed is not a parameter"});
}

TEST_F(Refusals, AGroupMustBeAGroup) {
  auto params = small_simulation();
  params.erase("camera/width");
  params.erase("camera/height");
  params.erase("camera/shadows");
  EXPECT_FALSE(manager_.load("/simulator", "simulator", with(params, {{"camera", 5}})));
  EXPECT_TRUE(log_.wait("/simulator/camera must be a group of parameters")) << log_.text();
}

TEST_F(Refusals, AnUnknownWorldIsReportedWithTheKnownOnes) {
  expect_refusal({{"world", std::string("atlantis")}},
                 {"there is no world 'atlantis'", "lab", "office", "random_floor"});
}

TEST_F(Refusals, ABrokenWorldIsReportedWithItsLine) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "broken.yaml";
  std::ofstream(file) << "name: broken\nobjects:\n  - dragon: {at: [0, 0]}\n";
  expect_refusal({{"world", file.string()}}, {file.string(), "dragon"});
}

TEST_F(Refusals, AMissingRobotIsNamed) {
  expect_refusal({{"urdf", std::string("/no/such/robot.urdf")}}, {"/no/such/robot.urdf"});
}

TEST_F(Refusals, ARobotWithoutItsSensorsOrJointsIsNamed) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "stick.urdf";
  std::ofstream(file) << "<robot name='stick'><link name='base_footprint'/></robot>";
  EXPECT_FALSE(manager_.load("/simulator", "simulator", with(small_simulation(), {{"urdf", file.string()}})));
  EXPECT_TRUE(wait_for([&] { return log_.text() != "(nothing was logged)"; }));
}

TEST_F(Refusals, FaultsThatAreNoneAreNamed) {
  XmlRpc::XmlRpcValue faults;
  faults[0] = fault_entry("earthquake", "", 1.0);
  expect_refusal({{"faults", faults}}, {"faults[0]/kind: unknown kind 'earthquake'"});
  log_.forget();
  faults[0] = fault_entry("joint_stuck", "knee", 1.0);
  faults[1] = fault_entry("camera_drop", "", 7.0);
  expect_refusal({{"faults", faults}}, {"no joint 'knee'", "camera_drop: value is a fraction"});
  log_.forget();
  expect_refusal({{"faults", std::string("many")}}, {"faults must be a list"});
  log_.forget();
  XmlRpc::XmlRpcValue wrong;
  wrong[0]["value"] = std::string("high");
  wrong[1]["when"] = 1.0;
  expect_refusal({{"faults", wrong}}, {"faults[0]/value has a value of a wrong type",
                                       "faults[1]/when: unknown key; a fault has kind, target, value"});
}

TEST_F(Refusals, ARandomWorldHasThePersonThatIsAskedFor) {
  (void)ros::param::del("/random");
  ros::param::set("/random/world", std::string("random_floor"));
  const auto by_chance = ros_params::load_simulator_params(ros::NodeHandle("/random"));
  ASSERT_TRUE(by_chance) << by_chance.error().message;
  ASSERT_TRUE(by_chance->random_world);
  EXPECT_EQ(by_chance->random_world->kind, simulate::RandomWorldParams::Kind::kFloor);
  EXPECT_EQ(by_chance->random_world->person, simulate::RandomWorldParams().person);
  ros::param::set("/random/random_world/person", 1.0);
  const auto always = ros_params::load_simulator_params(ros::NodeHandle("/random"));
  ASSERT_TRUE(always) << always.error().message;
  EXPECT_EQ(simulate::random_world(*always->random_world, 5)->people.size(), 1U);
}

TEST_F(Refusals, AFileOfPeopleThatIsMissingIsNamed) {
  (void)ros::param::del("/random");
  ros::param::set("/random/people_file", std::string("/nowhere/people.yaml"));
  const auto params = ros_params::load_simulator_params(ros::NodeHandle("/random"));
  ASSERT_TRUE(params) << params.error().message;
  EXPECT_EQ(params->people_file, "/nowhere/people.yaml");
  expect_refusal({{"people_file", std::string("/nowhere/people.yaml")}}, {"/nowhere/people.yaml"});
}

TEST_F(Refusals, ShippedConfigurationHasTheDocumentedDefaults) {
  (void)ros::param::del("/shipped");
  const auto defaults = ros_params::load_simulator_params(ros::NodeHandle("/shipped"));
  const std::string config = ros::package::getPath("extperfc") + "/config/";
  const std::string load = "rosparam load " + config + "simulator.yaml /shipped && rosparam load " + config +
                           "robot_interface.yaml /shipped/robot";
  ASSERT_EQ(std::system(load.c_str()), 0) << load;
  const auto shipped = ros_params::load_simulator_params(ros::NodeHandle("/shipped"));
  ASSERT_TRUE(defaults) << defaults.error().message;
  ASSERT_TRUE(shipped) << shipped.error().message;
  EXPECT_EQ(shipped->simulator.bodies.step_s, defaults->simulator.bodies.step_s);
  EXPECT_EQ(shipped->simulator.base.max_yaw_accel_rad_s2, defaults->simulator.base.max_yaw_accel_rad_s2);
  EXPECT_EQ(shipped->simulator.base.wheel_slip, defaults->simulator.base.wheel_slip);
  EXPECT_EQ(shipped->simulator.arms.start_pose, defaults->simulator.arms.start_pose);
  EXPECT_EQ(shipped->time.clock_hz, defaults->time.clock_hz);
  EXPECT_EQ(shipped->camera.rate_hz, defaults->camera.rate_hz);
  EXPECT_EQ(shipped->camera.camera.model.fx, defaults->camera.camera.model.fx);
  EXPECT_EQ(shipped->camera.camera.depth.subpixel_px, defaults->camera.camera.depth.subpixel_px);
  EXPECT_EQ(shipped->camera.camera.depth.edge_holes, defaults->camera.camera.depth.edge_holes);
  EXPECT_EQ(shipped->camera.camera.image_noise, defaults->camera.camera.image_noise);
  EXPECT_EQ(shipped->lidar.lidar.columns, 1875);
  EXPECT_EQ(shipped->lidar.lidar.columns, defaults->lidar.lidar.columns);
  EXPECT_EQ(shipped->lidar.lidar.range_noise_m, defaults->lidar.lidar.range_noise_m);
  EXPECT_EQ(shipped->truth.classes, defaults->truth.classes);
  EXPECT_EQ(shipped->truth.map_max_z_m, defaults->truth.map_max_z_m);
  (void)ros::param::del("/shipped");
}

}  // namespace
}  // namespace extperfc::ros_test
