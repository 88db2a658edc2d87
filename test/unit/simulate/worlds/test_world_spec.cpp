#include <cmath>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/simulate/random_world.hpp"
#include "extperfc/simulate/world_spec.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::simulate {
namespace {

const std::string kHead = "name: test\nfloor_plan: {min: [-3, -3], max: [3, 3]}\n";
const std::string kObjects = "objects:\n";  // line 3 when it follows kHead

WorldSpec read(const std::string& yaml) {
  const auto world = parse_world(yaml, "test.yaml");
  EXPECT_TRUE(world) << world.error().message;
  return world.value_or(WorldSpec{});
}

const BodySpec& body(const WorldSpec& world, const std::string& name) {
  for (const BodySpec& one : world.bodies)
    if (one.name == name) return one;
  throw std::runtime_error("no body " + name);
}

/// Every part stands in one line of the message that begins with `test.yaml:<line>: `.
void expect_problem(const std::string& yaml, int line, const std::vector<std::string>& parts) {
  const auto world = parse_world(yaml, "test.yaml");
  ASSERT_FALSE(world) << yaml;
  const std::string& message = world.error().message;
  const std::string start = "test.yaml:" + std::to_string(line) + ": ";
  bool found = false;
  for (std::size_t from = 0; from < message.size();) {
    const std::size_t end = std::min(message.find('\n', from), message.size());
    const std::string one = message.substr(from, end - from);
    bool all = one.rfind(start, 0) == 0;
    for (const auto& part : parts) all = all && one.find(part) != std::string::npos;
    found = found || all;
    from = end + 1;
  }
  EXPECT_TRUE(found) << "no line with " << start << parts[0] << " in:\n" << message;
}

void expect_object_problem(const std::string& object, const std::vector<std::string>& parts) {
  expect_problem(kHead + kObjects + "  - " + object + "\n", 4, parts);
}

TEST(WorldSpec, ReadsEveryPart) {
  const WorldSpec world = read(kHead + R"(
description: a room
robot: {at: [-1, 0.5], yaw_deg: 90}
light: {at: [0, 1, 2], direct: 0.5, ambient: 0.3, sky: [0.1, 0.2, 0.3]}
materials:
  ash: {like: oak, colour: "#ff0000", texture_size: 0.4, gloss: 0.2}
objects:
  - box: {name: crate, at: [1, 2, 0.5], size: [0.2, 0.4, 0.6], yaw_deg: 90, material: ash, mobility: movable}
people:
  - {name: eve, path: [[0, 1], [1, -1]], speed: 1.2, closed: true, colour: red, face: 12}
  - {name: ada, path: [[0, 2]]}
)");
  EXPECT_EQ(world.name, "test");
  EXPECT_EQ(world.description, "a room");
  EXPECT_DOUBLE_EQ(world.robot_start.x, -1);
  EXPECT_DOUBLE_EQ(world.robot_start.yaw, 90 * kDegree);
  EXPECT_EQ(world.light.position_m, Eigen::Vector3d(0, 1, 2));
  EXPECT_FLOAT_EQ(world.light.sky.z(), 0.3F);
  ASSERT_EQ(world.bodies.size(), 1U);
  const BodySpec& crate = world.bodies[0];
  EXPECT_EQ(crate.mobility, Mobility::kMovable);
  EXPECT_TRUE(crate.world_T_body.isApprox(make_pose({1, 2, 0.5}, {0, 0, 90 * kDegree})));
  ASSERT_EQ(crate.shapes.size(), 1U);
  EXPECT_EQ(std::get<Box>(crate.shapes[0].geometry).size_m, Eigen::Vector3d(0.2, 0.4, 0.6));
  EXPECT_NEAR(crate.shapes[0].body_T_shape.translation().z(), 0.3, 1e-12) << "`at` is the underside";
  EXPECT_EQ(crate.shapes[0].material.texture, Texture::kWood);
  EXPECT_EQ(crate.shapes[0].material.colour, Eigen::Vector3f(1, 0, 0));
  EXPECT_FLOAT_EQ(crate.shapes[0].material.gloss, 0.2F);
  ASSERT_EQ(world.people.size(), 2U);
  EXPECT_EQ(world.people[0].face, 12);
  EXPECT_FALSE(world.people[1].face) << "derived from the name when it is drawn";
  EXPECT_TRUE(world.people[0].closed);
  EXPECT_DOUBLE_EQ(world.people[0].speed_m_s, 1.2);
}

TEST(WorldSpec, LooseObjectsStandOnOthersWithTheirFrameInTheCentreOfMass) {
  const WorldSpec world = read(kHead + kObjects + R"(
  - table: {name: table, at: [1, 0], size: [0.8, 1.2, 0.7], yaw_deg: 30}
  - cone: {on: table, at: [1.1, 0.1], diameter: 0.08, height: 0.12, colour: red}
  - cube: {on: table, at: [0.9, 0], size: 0.05, colour: blue}
  - sphere: {on: cube_blue_1, at: [0.9, 0], diameter: 0.04, colour: "#00ff00"}
)");
  const BodySpec& cone = body(world, "cone_red_1");
  EXPECT_EQ(cone.label, "cone");
  EXPECT_EQ(cone.mobility, Mobility::kLoose);
  EXPECT_NEAR(cone.world_T_body.translation().z(), 0.7 + 0.03, 1e-9) << "a quarter of the height";
  EXPECT_NEAR(cone.shapes[0].body_T_shape.translation().z(), 0.03, 1e-9);
  EXPECT_NEAR(cone.mass_kg, 400 * kPi * 0.04 * 0.04 * 0.12 / 3, 1e-9);
  EXPECT_NEAR(body(world, "cube_blue_1").world_T_body.translation().z(), 0.725, 1e-9);
  EXPECT_NEAR(body(world, "sphere_1").world_T_body.translation().z(), 0.77, 1e-9);
}

TEST(WorldSpec, ShelvesHaveLevels) {
  const WorldSpec world = read(kHead + kObjects + R"(
  - shelf: {name: shelf, at: [1, 0], yaw_deg: 180, size: [0.3, 1, 1.672], levels: 4, books: 0}
  - can: {name: low, on: shelf, at: [1, 0.2]}
  - can: {name: high, on: shelf, level: 4, at: [1, 0.2]}
)");
  const double apart =
      body(world, "high").world_T_body.translation().z() - body(world, "low").world_T_body.translation().z();
  EXPECT_NEAR(apart, 3 * 0.4, 1e-9);
}

TEST(WorldSpec, GroupsMoveAndNameTheirObjects) {
  const WorldSpec world = read(kHead + kObjects + R"(
  - group: {name: a, at: [1, 1], yaw_deg: 90, objects: &two [{box: {name: box, at: [0.5, 0], size: [0.1, 0.1, 0.1]}},
                                                            {can: {on: box, at: [0.5, 0]}}]}
  - group: {name: b, at: [-1, -1], objects: *two}
)");
  ASSERT_EQ(world.bodies.size(), 4U);
  EXPECT_TRUE(body(world, "a_box").world_T_body.translation().isApprox(Eigen::Vector3d(1, 1.5, 0)));
  EXPECT_TRUE(body(world, "b_box").world_T_body.translation().isApprox(Eigen::Vector3d(-0.5, -1, 0)));
  EXPECT_GT(body(world, "a_can_1").world_T_body.translation().z(), 0.1);
}

TEST(WorldSpec, CopiesStandInARow) {
  const WorldSpec world =
      read(kHead + kObjects + "  - stool: {name: s, at: [1, 1], copies: {count: 3, step: [0, -0.5]}}\n");
  ASSERT_EQ(world.bodies.size(), 3U);
  EXPECT_TRUE(body(world, "s_3").world_T_body.translation().isApprox(Eigen::Vector3d(1, 0, 0)));
}

TEST(WorldSpec, DoorsHangInTheirOpenings) {
  const WorldSpec world = read(kHead + kObjects + R"(
  - wall: {path: [[-2, 1], [2, 1]], openings: [{at: [0.5, 1], width: 1, door: {name: d, open_deg: 90}}]}
)");
  const BodySpec& door = body(world, "d");
  EXPECT_EQ(door.mobility, Mobility::kMovable);
  EXPECT_TRUE(door.world_T_body.isApprox(make_pose({0, 1, 0}, {0, 0, 90 * kDegree}), 1e-9));
}

TEST(WorldSpecErrors, NameEveryProblemAtOnceInTheOrderOfTheFile) {
  const auto world = parse_world(
      "name: test\nfloor_plan: {min: [-3, -3], max: [3, 3]}\nrobt: {at: [0, 0]}\nobjects:\n"
      "  - box: {at: [1, 0], size: [1, -1, 1], colour: rad}\n  - tabel: {at: [0, 0]}\n",
      "w.yaml");
  ASSERT_FALSE(world);
  EXPECT_EQ(world.error().code, ErrorCode::kInvalidArgument);
  const std::string& message = world.error().message;
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 3) << message;
  EXPECT_LT(message.find("w.yaml:3: unknown key \"robt\""), message.find("w.yaml:5: objects[0].box.size[1]"));
  EXPECT_NE(message.find("did you mean \"robot\"?"), std::string::npos) << message;
  EXPECT_NE(message.find("w.yaml:5: objects[0].box.colour: unknown colour \"rad\", did you mean \"red\"?"),
            std::string::npos)
      << message;
  EXPECT_NE(
      message.find("w.yaml:6: objects[1].tabel: unknown kind of object \"tabel\", did you mean \"table\"?"),
      std::string::npos)
      << message;
}

TEST(WorldSpecErrors, OfTheFile) {
  const auto missing = load_world("/no/such/world.yaml");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_NE(missing.error().message.find("/no/such/world.yaml"), std::string::npos);
  const TemporaryFolder folder;
  const auto broken = load_world(folder.write("broken.yaml", "name: x\nobjects: [a\nb: c\n"));
  ASSERT_FALSE(broken);
  EXPECT_EQ(broken.error().code, ErrorCode::kCorrupt);
  EXPECT_NE(broken.error().message.find("broken.yaml:3: not YAML"), std::string::npos)
      << broken.error().message;
  EXPECT_FALSE(load_world(folder.path())) << "a folder";
  EXPECT_FALSE(parse_world("", "w"));
  EXPECT_FALSE(parse_world("- 1\n- 2\n", "w"));
  EXPECT_FALSE(parse_world("just text", "w"));
}

TEST(WorldSpecErrors, OfTheHead) {
  expect_problem("name: x\n", 1, {"floor_plan", "is missing"});
  expect_problem("floor_plan: {min: [0, 0], max: [1, 1]}\n", 1, {"name", "is missing"});
  expect_problem("name: x\nfloor_plan: {min: [0, 0], max: [1, 0]}\n", 2, {"floor_plan.max", "greater than"});
  expect_problem(kHead + "light: {direct: -1}\n", 3, {"light.direct", "[0, 2]"});
  expect_problem(kHead + "name: again\n", 3, {"name", "twice"});
  expect_problem(kHead + "materials: {m: {texture: wod}}\n", 3,
                 {"materials.m.texture", "did you mean \"wood\""});
  expect_problem(kHead + "objects: 3\n", 3, {"objects", "must be a list"});
}

TEST(WorldSpecErrors, OfObjects) {
  expect_object_problem("box: {at: [1, 0], size: [0, 1, 1]}", {"objects[0].box.size[0]", "[0.0001, 1000]"});
  expect_object_problem("box: {at: [1, 0], size: [1, 1]}", {"size", "3 numbers"});
  expect_object_problem("box: {at: [1, .nan], size: [1, 1, 1]}", {"at[1]", "must be a number"});
  expect_object_problem("box: {size: [1, 1, 1]}", {"at", "is missing"});
  expect_object_problem("box: {at: [1], size: [1, 1, 1]}", {"at", "must have 2 to 3 numbers"});
  expect_object_problem("box: {at: [1, 0], size: [1, 1, 1], mobility: loose}", {"mass", "kg"});
  expect_object_problem("box: {at: [1, 0], size: [1, 1, 1], mobility: floating}",
                        {"mobility", "fixed, movable or"});
  expect_object_problem("cube: {at: [1, 0], size: 0.1, mass: 0}", {"mass", "must be a number"});
  expect_object_problem("cube: {at: [1, 0], size: 0.1, texture: fur}", {"texture", "use one of none, wood"});
  expect_object_problem("cube: {at: [1, 0], size: 0.1, material: oka}", {"material", "did you mean \"oak\""});
  expect_object_problem("cube: {at: [1, 0], size: 0.1, on: table}", {"on", "no object \"table\""});
  expect_object_problem("cube: {at: [9, 0], size: 0.1}", {"outside the floor plan"});
  expect_object_problem("{}", {"one kind in each item"});
  expect_object_problem("box", {"must be a map"});
}

TEST(WorldSpecErrors, BetweenObjects) {
  const std::string table =
      kHead + kObjects + "  - table: {name: table, at: [1.5, 0], size: [0.8, 1.2, 0.7]}\n";
  expect_problem(table + "  - box: {name: table, at: [2.5, 2], size: [0.1, 0.1, 0.1]}\n", 5,
                 {"two objects \"table\"", "line 4"});
  expect_problem(table + "  - cube: {on: table, at: [2.2, 0], size: 0.05}\n", 5,
                 {"at", "not above \"table\""});
  expect_problem(table + "  - cube: {on: table, level: 2, at: [1.5, 0], size: 0.05}\n", 5,
                 {"level", "1 places"});
  expect_problem(table +
                     "  - cube: {name: a, on: table, at: [1.5, 0], size: 0.05}\n"
                     "  - cube: {name: b, on: table, at: [1.52, 0], size: 0.05}\n",
                 6, {"\"b\" and \"a\" are inside each other"});
  expect_problem(table + "  - cube: {name: a, at: [1.5, 0, 0.68], size: 0.05}\n", 5, {"\"a\" and \"table\""});
}

TEST(WorldSpecErrors, OfWalls) {
  const std::string wall = "wall: {path: [[-2, 1], [2, 1]], openings: ";
  expect_object_problem("wall: {path: [[-2, 1]]}", {"path", "at least 2 rows of 2 numbers"});
  expect_object_problem("wall: {path: [[-2, 1], [-2, 1.05]]}", {"path", "shorter"});
  expect_object_problem(wall + "[{at: [0, 2]}]}", {"openings[0].at", "not on the wall"});
  expect_object_problem(wall + "[{at: [1.8, 1]}]}", {"width", "over an end"});
  expect_object_problem(wall + "[{at: [0, 1]}, {at: [0.5, 1]}]}", {"openings[1].at", "overlaps"});
  expect_object_problem(wall + "[{at: [0, 1], top: 5}]}", {"top", "wall's height"});
  expect_object_problem(wall + "[{at: [0, 1], door: {hinge: up}}]}", {"hinge", "left or right"});
}

TEST(WorldSpecErrors, OfGroupsThatHoldThemselves) {
  const auto cyclic =
      parse_world(kHead + "objects: &all\n  - group: {name: g, at: [0, 0], objects: *all}\n", "test.yaml");
  ASSERT_FALSE(cyclic);
  EXPECT_NE(cyclic.error().message.find("does this one hold itself?"), std::string::npos)
      << cyclic.error().message;
  // Ten times ten times ten times ten boxes.
  std::string yaml = kHead + "templates:\n  - &g0 [{box: {at: [0, 2], size: [0.1, 0.1, 0.1]}}]\n";
  for (int level = 1; level <= 4; ++level) {
    const std::string group = "{group: {at: [0, 0], objects: *g" + std::to_string(level - 1) + "}}";
    yaml += "  - &g" + std::to_string(level) + " [";
    for (int i = 0; i < 10; ++i) yaml += (i == 0 ? "" : ", ") + group;
    yaml += "]\n";
  }
  const auto many = parse_world(yaml + "objects: *g4\n", "test.yaml");
  ASSERT_FALSE(many);
  EXPECT_NE(many.error().message.find("more than 5000 objects"), std::string::npos);
  EXPECT_LT(many.error().message.size(), 1000000U);
}

TEST(WorldSpecErrors, OfTheRobot) {
  expect_problem(kHead + "robot: {at: [5, 0]}\n", 3, {"robot", "outside the floor plan"});
  expect_problem(
      kHead + "robot: {at: [1, 0.3]}\nobjects: [{box: {name: b, at: [1, 0], size: [0.4, 0.4, 1]}}]\n", 3,
      {"robot", "\"b\""});
}

TEST(WorldSpecErrors, OfPeople) {
  expect_problem(kHead + "people:\n  - {name: eve, path: [[0, 5]]}\n", 4,
                 {"people[0]", "outside the floor plan"});
  for (const std::string wrong : {"-1", "2.5", "1000000", "round", "[1]"})
    expect_problem(kHead + "people:\n  - {name: eve, path: [[0, 1]], face: " + wrong + "}\n", 4,
                   {"people[0].face: must be a whole number in [0, 999999], not "});
  expect_problem(kHead + "people:\n  - {name: eve, path: []}\n", 4, {"people[0].path", "at least 1"});
  expect_problem(kHead + "people:\n  - {name: eve, path: [[0, 1]]}\n  - {name: eve, path: [[0, 2]]}\n", 5,
                 {"two people \"eve\""});
  expect_problem(kHead +
                     "people:\n  - {name: eve, path: [[-2, 1], [2, 1]]}\n"
                     "objects: [{box: {name: b, at: [0, 1], size: [0.4, 0.4, 1]}}]\n",
                 4, {"\"eve\" walks into \"b\""});
  expect_problem(kHead +
                     "people:\n  - {name: b, path: [[-2, 1]]}\n"
                     "objects: [{box: {name: b, at: [1, 1], size: [0.4, 0.4, 1]}}]\n",
                 4, {"an object has the name \"b\" too"});
}

TEST(WithPeople, AreAddedToAnyWorld) {
  RandomWorldParams params;
  params.kind = RandomWorldParams::Kind::kFloor;
  params.person = 1;
  const auto world = *random_world(params, 3);
  ASSERT_EQ(world.people.size(), 1U);
  const Eigen::Vector2d free = world.people[0].path_m[0];
  std::ostringstream text;
  text << "people:\n  - {name: eve, speed: 0.7, path: [[" << free.x() << ", " << free.y() << "]]}\n";
  const TemporaryFolder folder;
  const auto more = with_people(world, folder.write("people.yaml", text.str()));
  ASSERT_TRUE(more) << more.error().message;
  ASSERT_EQ(more->people.size(), 2U);
  EXPECT_EQ(more->people[0].name, world.people[0].name);
  EXPECT_EQ(more->people[1].name, "eve");
  EXPECT_EQ(more->bodies.size(), world.bodies.size());
}

TEST(WithPeople, WhatIsWrongIsNamed) {
  const auto world = *parse_world(kHead +
                                      "people:\n  - {name: eve, path: [[0, 0]]}\nobjects: [{box: {name: b, "
                                      "at: [0, 1], size: [0.4, 0.4, 1]}}]\n",
                                  "world.yaml");
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"people:\n  - {name: bob, path: [[-2, 1], [2, 1]]}\n", "\"bob\" walks into \"b\""},
      {"people:\n  - {name: eve, path: [[1, 0]]}\n", "two people \"eve\""},
      {"people:\n  - {name: bob, path: [[0, 50]]}\n", "outside the floor plan"},
      {"people:\n  - {name: b, path: [[1, 0]]}\n", "an object has the name"},
      {"person: []\n", "person"}};
  const TemporaryFolder folder;
  for (const auto& [text, problem] : wrong) {
    const auto refused = with_people(world, folder.write("more.yaml", text));
    ASSERT_FALSE(refused) << text;
    EXPECT_NE(refused.error().message.find(problem), std::string::npos) << refused.error().message;
    EXPECT_NE(refused.error().message.find("more.yaml"), std::string::npos) << "names the file";
  }
  EXPECT_FALSE(with_people(world, "/nowhere/people.yaml"));
}

}  // namespace
}  // namespace extperfc::simulate
