#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/world/robot_model.hpp"

#include "test/support/temporary_folder.hpp"
#include "test/unit/world/robot/robot_text.hpp"

namespace extperfc {
namespace {

/// What is wrong with a description, and what the error must say.
struct Bad {
  std::string name;
  std::string xml;
  ErrorCode code;
  std::vector<std::string> expected;
};

void PrintTo(const Bad& bad, std::ostream* out) {
  *out << bad.name;
}

RobotText with_carriage(const std::string& carriage) {
  RobotText text;
  text.carriage = carriage;
  return text;
}

RobotText with_swivel(const std::string& swivel, const std::string& type = "revolute") {
  RobotText text;
  text.swivel = swivel;
  text.swivel_type = type;
  return text;
}

RobotText with_more(const std::string& more) {
  RobotText text;
  text.more = more;
  return text;
}

std::string mesh(const std::string& uri, const std::string& scale = "1 1 1") {
  return with_carriage(R"(<visual><geometry><mesh filename=")" + uri + R"(" scale=")" + scale +
                       R"("/></geometry></visual>)")
      .xml();
}

std::string shape(const std::string& geometry) {
  return with_carriage("<collision><geometry>" + geometry + "</geometry></collision>").xml();
}

std::string inertial(const std::string& mass, const std::string& ixx) {
  return with_carriage(R"(<inertial><mass value=")" + mass + R"("/><inertia ixx=")" + ixx +
                       R"(" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>)")
      .xml();
}

std::string joint(const std::string& name, const std::string& parent, const std::string& child,
                  const std::string& more = "") {
  return R"(<joint name=")" + name + R"(" type="revolute"><parent link=")" + parent + R"("/><child link=")" +
         child + R"("/><axis xyz="1 0 0"/><limit lower="0" upper="1" effort="1" velocity="1"/>)" + more +
         "</joint>";
}

std::string mimic(const std::string& of) {
  return R"(<link name="tail"/>)" + joint("back", "tool", "tail", R"(<mimic joint=")" + of + R"("/>)");
}

const std::string kLimit = R"(<limit lower="-1" upper="1" effort="3" velocity="2"/>)";

std::vector<Bad> documents() {
  return {
      {"Empty", "", ErrorCode::kCorrupt, {"not a valid URDF"}},
      {"NotXml", "link: base", ErrorCode::kCorrupt, {"not a valid URDF"}},
      {"CutOff", RobotText{}.xml().substr(0, 300), ErrorCode::kCorrupt, {"not a valid URDF"}},
      {"OtherRoot", "<sdf/>", ErrorCode::kCorrupt, {"not a valid URDF", "robot"}},
      {"NoLinks", "<robot name='x'/>", ErrorCode::kCorrupt, {"not a valid URDF", "link"}},
      {"NoName", "<robot><link name='a'/></robot>", ErrorCode::kCorrupt, {"name"}},
      {"LinkTwice", with_more("<link name='tool'/>").xml(), ErrorCode::kCorrupt, {"tool"}},
      {"JointTwice",
       with_more("<link name='b'/>" + joint("swivel", "tool", "b")).xml(),
       ErrorCode::kCorrupt,
       {"swivel"}},
  };
}

std::vector<Bad> trees() {
  return {
      {"TwoRoots", with_more("<link name='alone'/>").xml(), ErrorCode::kCorrupt, {"root", "alone"}},
      {"MissingChild", with_more(joint("j", "tool", "ghost")).xml(), ErrorCode::kCorrupt, {"ghost"}},
      {"MissingParent",
       with_more("<link name='b'/>" + joint("j", "ghost", "b")).xml(),
       ErrorCode::kCorrupt,
       {"ghost"}},
      {"TwoParents",
       with_more(joint("second", "base", "tool")).xml(),
       ErrorCode::kCorrupt,
       {"tool", "swivel", "second"}},
      {"Loop",
       with_more("<link name='a'/><link name='b'/>" + joint("ab", "a", "b") + joint("ba", "b", "a")).xml(),
       ErrorCode::kCorrupt,
       {"'a'", "loop"}},
#ifndef __SANITIZE_ADDRESS__  // urdfdom refuses it, but never frees the loop
      {"OnlyALoop",
       "<robot name='x'><link name='a'/><link name='b'/>" + joint("ab", "a", "b") + joint("ba", "b", "a") +
           "</robot>",
       ErrorCode::kCorrupt,
       {"root"}},
#endif
      {"MissingMimic", with_more(mimic("ghost")).xml(), ErrorCode::kNotFound, {"'back'", "'ghost'"}},
      {"MimicOfItself", with_more(mimic("back")).xml(), ErrorCode::kInvalidArgument, {"'back'", "driven"}},
  };
}

std::vector<Bad> joints() {
  return {
      {"Floating", with_swivel("", "floating").xml(), ErrorCode::kUnsupported, {"'swivel'", "revolute"}},
      {"Planar",
       with_swivel("<axis xyz='0 0 1'/>", "planar").xml(),
       ErrorCode::kUnsupported,
       {"'swivel'", "planar"}},
      {"UnknownType", with_swivel(kLimit, "ball").xml(), ErrorCode::kCorrupt, {"swivel", "ball"}},
      {"NoLimit", with_swivel("<axis xyz='0 0 1'/>").xml(), ErrorCode::kCorrupt, {"swivel", "limit"}},
      {"NoVelocity",
       with_swivel("<limit lower='0' upper='1' effort='1'/>").xml(),
       ErrorCode::kCorrupt,
       {"velocity"}},
      {"LimitsSwapped",
       with_swivel("<limit lower='1' upper='-1' effort='1' velocity='1'/>").xml(),
       ErrorCode::kInvalidArgument,
       {"'swivel'", "lower"}},
      {"NegativeVelocity",
       with_swivel("<limit lower='0' upper='1' effort='1' velocity='-1'/>").xml(),
       ErrorCode::kInvalidArgument,
       {"'swivel'", "velocity"}},
      {"ZeroAxis",
       with_swivel("<axis xyz='0 0 0'/>" + kLimit).xml(),
       ErrorCode::kInvalidArgument,
       {"'swivel'", "axis"}},
      {"NoNumber", with_swivel("<axis xyz='0 zero 1'/>" + kLimit).xml(), ErrorCode::kCorrupt, {"zero"}},
      {"NotFinite",
       with_swivel("<axis xyz='0 nan 1'/>" + kLimit).xml(),
       ErrorCode::kCorrupt,
       {"not a valid URDF"}},
      {"DecimalComma", with_swivel("<origin xyz='0,5 0 1'/>" + kLimit).xml(), ErrorCode::kCorrupt, {"0,5"}},
  };
}

std::vector<Bad> links() {
  return {
      {"NoGeometry", with_carriage("<collision/>").xml(), ErrorCode::kCorrupt, {"not a valid URDF"}},
      {"FlatBox", shape("<box size='1 0 1'/>"), ErrorCode::kInvalidArgument, {"'carriage'", "size"}},
      {"NegativeCylinder",
       shape("<cylinder radius='0.1' length='-1'/>"),
       ErrorCode::kInvalidArgument,
       {"'carriage'"}},
      {"EmptySphere", shape("<sphere radius='0'/>"), ErrorCode::kInvalidArgument, {"'carriage'"}},
      {"NegativeMass", inertial("-1", "1"), ErrorCode::kInvalidArgument, {"'carriage'", "mass"}},
      {"NegativeInertia", inertial("1", "-1"), ErrorCode::kInvalidArgument, {"'carriage'", "ixx"}},
      {"MeshOfAnotherPackage",
       mesh("package://other/a.stl"),
       ErrorCode::kUnsupported,
       {"package://other/a.stl"}},
      {"MeshByFile", mesh("file:///a.stl"), ErrorCode::kUnsupported, {"file:///a.stl"}},
      {"MissingMesh",
       mesh("package://extperfc/ghost.stl"),
       ErrorCode::kNotFound,
       {"'carriage'", "ghost.stl"}},
      {"MeshOutside", mesh("package://extperfc/../a.stl"), ErrorCode::kInvalidArgument, {"'..'"}},
      {"MeshIsAFolder", mesh("package://extperfc/."), ErrorCode::kNotFound, {"mesh"}},
      {"MeshWithoutScale",
       mesh("package://extperfc/good.stl", "1 0 1"),
       ErrorCode::kInvalidArgument,
       {"scale"}},
      {"TextMesh", mesh("package://extperfc/text.stl"), ErrorCode::kCorrupt, {"text.stl", "binary STL"}},
      {"EmptyMesh", mesh("package://extperfc/empty.stl"), ErrorCode::kCorrupt, {"empty.stl"}},
      {"CutOffMesh", mesh("package://extperfc/cut.stl"), ErrorCode::kCorrupt, {"cut.stl"}},
  };
}

class BadUrdf : public testing::TestWithParam<Bad> {};

TEST_P(BadUrdf, GivesOneClearError) {
  const TemporaryFolder folder;
  std::string triangle(84 + 50, '\0');
  triangle[80] = 1;
  folder.write("good.stl", triangle);
  folder.write("cut.stl", triangle.substr(0, 120));
  folder.write("empty.stl", std::string(84, '\0'));
  folder.write("text.stl", "solid cube\nendsolid\n");
  testing::internal::CaptureStderr();
  const auto robot = RobotModel::from_urdf(GetParam().xml, folder.path());
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "the library's log got out";
  ASSERT_FALSE(robot) << "accepted";
  EXPECT_EQ(robot.error().code, GetParam().code) << robot.error().message;
  for (const std::string& text : GetParam().expected)
    EXPECT_NE(robot.error().message.find(text), std::string::npos)
        << text << " is not in: " << robot.error().message;
}

std::string name_of(const testing::TestParamInfo<Bad>& info) {
  return info.param.name;
}
INSTANTIATE_TEST_SUITE_P(Documents, BadUrdf, testing::ValuesIn(documents()), name_of);
INSTANTIATE_TEST_SUITE_P(Trees, BadUrdf, testing::ValuesIn(trees()), name_of);
INSTANTIATE_TEST_SUITE_P(Joints, BadUrdf, testing::ValuesIn(joints()), name_of);
INSTANTIATE_TEST_SUITE_P(Links, BadUrdf, testing::ValuesIn(links()), name_of);

TEST(BadUrdfFile, IsNamed) {
  const TemporaryFolder folder;
  const auto missing = RobotModel::from_file(folder.path() / "ghost.urdf", folder.path());
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_NE(missing.error().message.find("ghost.urdf"), std::string::npos) << missing.error().message;
  const auto bad = RobotModel::from_file(folder.write("bad.urdf", "<robot/>"), folder.path());
  ASSERT_FALSE(bad);
  EXPECT_NE(bad.error().message.find("bad.urdf"), std::string::npos) << bad.error().message;
}

}  // namespace
}  // namespace extperfc
