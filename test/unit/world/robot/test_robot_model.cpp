#include <clocale>
#include <cmath>
#include <locale>
#include <thread>

#include <gtest/gtest.h>

#include "extperfc/world/robot_model.hpp"

#include "test/support/temporary_folder.hpp"
#include "test/unit/world/robot/robot_text.hpp"

namespace extperfc {
namespace {

RobotModel model(const std::string& xml, const std::filesystem::path& root = ".") {
  auto result = RobotModel::from_urdf(xml, root);
  if (!result) throw std::runtime_error(result.error().message);
  return *std::move(result);
}

/// A binary STL file with `triangles` triangles of zeros.
std::string stl(unsigned triangles) {
  std::string bytes(84 + 50 * triangles, '\0');
  bytes[80] = static_cast<char>(triangles);
  return bytes;
}

TEST(RobotModel, KeepsTheTreeFromTheRoot) {
  const RobotModel robot = model(RobotText{}.xml());
  EXPECT_EQ(robot.name(), "slider");
  ASSERT_EQ(robot.links().size(), 3U);
  EXPECT_EQ(robot.links()[0].parent_joint, -1);
  EXPECT_EQ(robot.links()[2].name, "tool");
  EXPECT_EQ(robot.links()[2].parent_joint, robot.joint("swivel"));
  EXPECT_EQ(robot.link("carriage"), 1);
  EXPECT_FALSE(robot.link("slide"));
  EXPECT_FALSE(robot.joint("carriage"));
}

TEST(RobotModel, ReadsALinksBody) {
  const Link link = model(RobotText{}.xml()).links()[1];
  ASSERT_TRUE(link.inertial);
  EXPECT_EQ(link.inertial->mass_kg, 2);
  EXPECT_DOUBLE_EQ(link.inertial->link_T_com.translation().z(), 0.1);
  EXPECT_EQ(link.inertial->inertia_kg_m2(0, 1), 0.01);
  EXPECT_EQ(link.inertial->inertia_kg_m2(1, 0), 0.01);
  EXPECT_EQ(link.inertial->inertia_kg_m2(2, 2), 0.3);
  ASSERT_EQ(link.visuals.size(), 1U);
  EXPECT_EQ(std::get<Box>(link.visuals[0].geometry).size_m, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_TRUE(link.visuals[0].material.colour.isApprox(Eigen::Vector3f(0.8F, 0.1F, 0.05F)));
  ASSERT_EQ(link.collisions.size(), 1U);
  EXPECT_EQ(std::get<Cylinder>(link.collisions[0].geometry).length_m, 0.3);
  EXPECT_EQ(link.collisions[0].body_T_shape.translation().z(), 0.15);
}

TEST(RobotModel, ReadsAJoint) {
  const Joint joint = model(RobotText{}.xml()).joints()[0];
  EXPECT_EQ(joint.type, JointType::kPrismatic);
  EXPECT_EQ(joint.axis, Eigen::Vector3d::UnitY()) << "not normalised";
  EXPECT_EQ(joint.lower, -0.5);
  EXPECT_EQ(joint.upper, 0.25);
  EXPECT_EQ(joint.max_velocity, 0.4);
  EXPECT_EQ(joint.max_effort, 20);
}

TEST(RobotModel, ContinuousJointsHaveNoEnds) {
  RobotText text;
  text.swivel_type = "continuous";
  const Joint joint = model(text.xml()).joints()[1];
  EXPECT_EQ(joint.type, JointType::kContinuous);
  EXPECT_EQ(joint.lower, -INFINITY);
  EXPECT_EQ(joint.upper, INFINITY);
  EXPECT_EQ(joint.max_velocity, 2);
}

TEST(RobotModel, MovesLinks) {
  const RobotModel robot = model(RobotText{}.xml());
  const auto poses = robot.link_poses({0.2, M_PI / 2});
  EXPECT_TRUE(poses[0].isApprox(Pose::Identity()));
  EXPECT_TRUE(poses[1].isApprox(make_pose({1, 0.2, 0})));
  EXPECT_TRUE(poses[2].isApprox(make_pose({1, 0.2, 0.5}, {0, 0, M_PI / 2})));
  EXPECT_THROW((void)robot.link_poses({0.2}), std::out_of_range);
}

TEST(RobotModel, MimicJointsFollow) {
  RobotText text;
  text.more =
      R"(<link name="tail"/><joint name="back" type="revolute"><parent link="tool"/><child link="tail"/>
      <axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/>
      <mimic joint="swivel" multiplier="-2" offset="0.25"/></joint>)";
  const RobotModel robot = model(text.xml());
  ASSERT_TRUE(robot.joints()[*robot.joint("back")].mimic);
  std::vector<double> positions(3, 99.0);
  positions[*robot.joint("slide")] = 0;
  positions[*robot.joint("swivel")] = 0.3;
  const Pose tail = robot.link_poses(positions)[*robot.link("tail")];
  EXPECT_TRUE(tail.isApprox(make_pose({1, 0, 0.5}, {0, 0, 0.3 - 2 * 0.3 + 0.25})));
}

TEST(RobotModel, FindsMeshesInThePackage) {
  const TemporaryFolder folder;
  folder.write("meshes/a.stl", stl(2));
  RobotText text;
  text.carriage = R"(<visual><geometry>
      <mesh filename="package://extperfc/meshes/a.stl" scale="1 2 3"/></geometry></visual>)";
  const RobotModel robot = model(text.xml(), folder.path());
  const auto mesh = std::get<TriangleMesh>(robot.links()[1].visuals[0].geometry);
  EXPECT_EQ(mesh.path, folder.path() / "meshes/a.stl");
  EXPECT_EQ(mesh.scale, Eigen::Vector3d(1, 2, 3));
}

TEST(RobotModel, ReadsFiles) {
  const TemporaryFolder folder;
  const auto file = folder.write("slider.urdf", RobotText{}.xml());
  const auto robot = RobotModel::from_file(file, folder.path());
  ASSERT_TRUE(robot) << robot.error().message;
  EXPECT_EQ(robot->links().size(), 3U);
}

/// A decimal comma for every stream that does not choose its locale.
struct DecimalComma : std::numpunct<char> {
  [[nodiscard]] char do_decimal_point() const override { return ','; }
};

TEST(RobotModel, ADecimalCommaOfTheStreamsChangesNothing) {
  const std::locale before = std::locale::global(std::locale(std::locale(), new DecimalComma));
  const auto robot = RobotModel::from_urdf(RobotText{}.xml(), ".");
  std::locale::global(before);
  ASSERT_TRUE(robot) << robot.error().message;
  EXPECT_EQ(robot->joints()[0].lower, -0.5);
}

TEST(RobotModel, ADecimalCommaOfTheProcessChangesNothing) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  const char* found = nullptr;
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "es_ES.UTF-8", "fr_FR.UTF-8"})
    if (found == nullptr) found = std::setlocale(LC_ALL, name);
  if (found == nullptr) GTEST_SKIP() << "no locale with a decimal comma is installed (Debian: locales-all)";
  const auto robot = RobotModel::from_urdf(RobotText{}.xml(), ".");
  EXPECT_STREQ(std::localeconv()->decimal_point, ",") << "the locale was not given back";
  std::setlocale(LC_ALL, before.c_str());
  ASSERT_TRUE(robot) << robot.error().message;
  EXPECT_EQ(robot->joints()[0].lower, -0.5);
}

TEST(RobotModel, IsReadByManyThreadsAtOnce) {
  std::vector<std::thread> threads;
  std::vector<std::string> outcomes(8);
  for (std::size_t i = 0; i < outcomes.size(); ++i)
    threads.emplace_back([&outcome = outcomes[i], good = i % 2 == 0] {
      const auto robot = RobotModel::from_urdf(good ? RobotText{}.xml() : "<robot name='x'/>", ".");
      outcome = robot ? "read" : robot.error().message;
    });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < outcomes.size(); i += 2) EXPECT_EQ(outcomes[i], "read");
  for (std::size_t i = 1; i < outcomes.size(); i += 2) EXPECT_EQ(outcomes[i], outcomes[1]);
}

}  // namespace
}  // namespace extperfc
