#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/simulate/floor_plan.hpp"
#include "extperfc/simulate/world_spec.hpp"

namespace extperfc::simulate {
namespace {

namespace fs = std::filesystem;

const fs::path kWorlds = fs::path(EXTPERFC_SOURCE_DIR) / "config/worlds";

WorldSpec load(const std::string& name) {
  const auto world = load_world(kWorlds / (name + ".yaml"));
  EXPECT_TRUE(world) << world.error().message;
  return world.value_or(WorldSpec{});
}

std::map<std::string, int> labels_of(const WorldSpec& world) {
  std::map<std::string, int> labels;
  for (const BodySpec& body : world.bodies) ++labels[body.label];
  return labels;
}

TEST(ShippedWorlds, AllLoad) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(kWorlds)) {
    if (entry.path().extension() != ".yaml") continue;
    const auto world = load_world(entry.path());
    ASSERT_TRUE(world) << world.error().message;
    EXPECT_EQ(world->name, entry.path().stem().string()) << "a world is named as its file";
    names.insert(world->name);
  }
  for (const char* name : {"lab", "office", "bookshelf", "empty", "flat", "grasp"})
    EXPECT_EQ(names.count(name), 1U) << name;
}

TEST(ShippedWorlds, LabIsThePapersScenario) {
  const WorldSpec lab = load("lab");
  const auto labels = labels_of(lab);
  for (const char* label : {"cone", "cube", "sphere"}) EXPECT_EQ(labels.at(label), 4) << label;
  EXPECT_GE(lab.people.size(), 1U);
  for (const BodySpec& body : lab.bodies) {
    if (body.label.empty()) continue;
    EXPECT_EQ(body.mobility, Mobility::kLoose) << body.name;
    EXPECT_GT(body.world_T_body.translation().z(), 0.62) << body.name << " is on the table";
    EXPECT_LT(body.world_T_body.translation().head<2>().norm(), 1.3) << body.name << " is within reach";
    EXPECT_LT(body.mass_kg, 0.5) << body.name;
    if (const auto* box = std::get_if<Box>(&body.shapes[0].geometry)) {
      EXPECT_GE(box->size_m.x(), 0.016) << body.name << " fits the gripper";
      EXPECT_LE(box->size_m.x(), 0.057) << body.name << " fits the gripper";
    }
  }
}

TEST(ShippedWorlds, GraspHasOneObjectOfEachKindThatFitsTheGripperAndATrayToMove) {
  const WorldSpec world = load("grasp");
  const auto labels = labels_of(world);
  for (const char* label : {"cone", "cube", "sphere"}) EXPECT_EQ(labels.at(label), 1) << label;
  std::map<std::string, const BodySpec*> bodies;
  for (const BodySpec& body : world.bodies) bodies[body.name] = &body;
  for (const char* name : {"tray", "column"}) {
    ASSERT_EQ(bodies.count(name), 1U) << name;
    EXPECT_EQ(bodies[name]->mobility, Mobility::kMovable) << name;
  }
  // tools/lib/grasp_scene.py has the same figures.
  EXPECT_EQ(std::get<Box>(bodies["tray"]->shapes[0].geometry).size_m, Eigen::Vector3d(0.46, 0.70, 0.03));
  EXPECT_EQ(std::get<Box>(bodies["cube"]->shapes[0].geometry).size_m, Eigen::Vector3d::Constant(0.045));
  EXPECT_EQ(std::get<Sphere>(bodies["sphere"]->shapes[0].geometry).radius_m, 0.025);
  EXPECT_EQ(std::get<Cone>(bodies["cone"]->shapes[0].geometry).radius_m, 0.03);
  EXPECT_EQ(std::get<Cone>(bodies["cone"]->shapes[0].geometry).height_m, 0.09);
}

TEST(ShippedWorlds, OfficeIsLargeAndFull) {
  const WorldSpec office = load("office");
  const Eigen::Vector2d size = office.max_m - office.min_m;
  EXPECT_GE(size.x(), 30);
  EXPECT_GE(size.y(), 20);
  EXPECT_GT(office.bodies.size(), 60U);
  EXPECT_GE(office.people.size(), 2U);
  int open = 0;
  int shut = 0;
  for (const BodySpec& body : office.bodies) {
    if (body.name.rfind("door_", 0) != 0) continue;
    EXPECT_EQ(body.mobility, Mobility::kMovable) << body.name;
    const Eigen::Vector3d leaf = body.world_T_body.linear().col(0).cwiseAbs();
    (leaf.head<2>().maxCoeff() > 0.999 && std::abs(leaf.maxCoeff() - 1) < 1e-9 ? shut : open) += 1;
  }
  EXPECT_GE(open, 5);
  EXPECT_GE(shut, 3);
}

TEST(ShippedWorlds, OfficeHasLoopsAroundItsCore) {
  const WorldSpec office = load("office");
  const auto plan = floor_plan(office, 0.1, 0.1, 1.5);
  ASSERT_TRUE(plan) << plan.error().message;
  const auto free_line = [&](Eigen::Vector2d from, Eigen::Vector2d to) {
    for (double fraction = 0; fraction <= 1; fraction += 0.005) {
      const Eigen::Vector2d cell = (from + (to - from) * fraction - plan->origin_m) / plan->resolution_m;
      if (plan->at(static_cast<int>(cell.x()), static_cast<int>(cell.y())) != kFreeCell) return false;
    }
    return true;
  };
  const std::vector<Eigen::Vector2d> ring{{-11, 3.7}, {0, 3.7},  {11, 3.7},
                                          {11, -3.5}, {0, -3.5}, {-11, -3.5}};
  for (std::size_t i = 0; i < ring.size(); ++i)
    EXPECT_TRUE(free_line(ring[i], ring[(i + 1) % ring.size()])) << i;
  EXPECT_TRUE(free_line({0, 3.7}, {0, -3.5})) << "the passage through the middle";
}

TEST(ShippedWorlds, BookshelfHasObjectsWithinReachOnThreeLevels) {
  const WorldSpec world = load("bookshelf");
  std::set<int> levels;
  for (const BodySpec& body : world.bodies)
    if (body.mobility == Mobility::kLoose)
      levels.insert(static_cast<int>(body.world_T_body.translation().z() / 0.4));
  EXPECT_GE(levels.size(), 3U);
}

}  // namespace
}  // namespace extperfc::simulate
