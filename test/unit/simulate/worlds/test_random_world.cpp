#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/simulate/floor_plan.hpp"
#include "extperfc/simulate/random_world.hpp"
#include "extperfc/world/shape_extent.hpp"

#include "simulate/worlds/solid.hpp"

namespace extperfc::simulate {
namespace {

constexpr std::uint64_t kSeeds = 200;

WorldSpec make(std::uint64_t seed, const RandomWorldParams& params = {}) {
  const auto world = random_world(params, seed);
  EXPECT_TRUE(world) << world.error().message;
  return world.value_or(WorldSpec{});
}

/// Every number of a world, for comparing bit by bit.
std::vector<double> numbers_of(const WorldSpec& world) {
  std::vector<double> numbers{world.min_m.x(), world.max_m.y(), world.light.position_m.x(),
                              static_cast<double>(world.light.direct)};
  for (const BodySpec& body : world.bodies) {
    numbers.insert(numbers.end(), body.world_T_body.data(), body.world_T_body.data() + 16);
    numbers.push_back(body.mass_kg);
    for (const Shape& shape : body.shapes) {
      numbers.insert(numbers.end(), shape.body_T_shape.data(), shape.body_T_shape.data() + 16);
      numbers.push_back(volume_m3(shape.geometry));
      for (int i = 0; i < 3; ++i) numbers.push_back(static_cast<double>(shape.material.colour[i]));
    }
  }
  for (const PersonSpec& person : world.people) numbers.push_back(person.path_m.at(0).x());
  for (const PersonSpec& person : world.people) numbers.push_back(person.face.value());
  return numbers;
}

VerticalExtent heights_of(const BodySpec& body) {
  return vertical_extent(body.shapes, body.world_T_body);
}

/// A shape's outline and heights in the world.
struct Extent {
  Polygon outline;
  VerticalExtent heights;
};

std::vector<Extent> extents_of(const BodySpec& body) {
  std::vector<Extent> list;
  for (const Shape& shape : body.shapes) {
    const Pose pose = body.world_T_body * shape.body_T_shape;
    list.push_back({*outline(shape.geometry, pose, -1, 10), vertical_extent(shape.geometry, pose)});
  }
  return list;
}

/// Whether two bodies overlap by more than `slack` in height and seen from above.
bool may_touch(const std::vector<Extent>& a, const std::vector<Extent>& b, double slack) {
  for (const Extent& one : a)
    for (const Extent& other : b) {
      const bool level = one.heights.low_m < other.heights.high_m - slack &&
                         other.heights.low_m < one.heights.high_m - slack;
      if (level && overlap(one.outline, other.outline, slack)) return true;
    }
  return false;
}

std::vector<const BodySpec*> loose_bodies(const WorldSpec& world) {
  std::vector<const BodySpec*> list;
  for (const BodySpec& body : world.bodies)
    if (body.mobility == Mobility::kLoose) list.push_back(&body);
  return list;
}

const BodySpec& table_of(const WorldSpec& world) {
  return *std::find_if(world.bodies.begin(), world.bodies.end(),
                       [](const BodySpec& body) { return body.name.rfind("table", 0) == 0; });
}

TEST(RandomWorld, SameSeedSameWorld) {
  for (const auto kind : {RandomWorldParams::Kind::kTable, RandomWorldParams::Kind::kFloor})
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      RandomWorldParams params;
      params.kind = kind;
      const auto numbers = numbers_of(make(seed, params));
      EXPECT_EQ(numbers, numbers_of(make(seed, params))) << "seed " << seed;
      EXPECT_NE(numbers, numbers_of(make(seed + 1000, params))) << "seed " << seed;
    }
}

TEST(RandomWorld, ObjectsStandOnTheTableOrOnEachOther) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const WorldSpec world = make(seed);
    const BodySpec& table = table_of(world);
    const double top = heights_of(table).high_m;
    const auto loose = loose_bodies(world);
    for (const BodySpec* body : loose) {
      const double low = heights_of(*body).low_m;
      const bool on_table = std::abs(low - top) < 2e-3;
      const bool on_another = std::any_of(loose.begin(), loose.end(), [&](const BodySpec* other) {
        const double apart =
            (other->world_T_body.translation() - body->world_T_body.translation()).head<2>().norm();
        return other != body && apart < 0.03 && std::abs(heights_of(*other).high_m - low) < 2e-3;
      });
      EXPECT_TRUE(on_table || on_another)
          << "seed " << seed << ": " << body->name << " at " << low << ", top " << top;
      EXPECT_GT(body->mass_kg, 0) << "seed " << seed << ": " << body->name;
      const Eigen::Vector3d local = table.world_T_body.inverse() * body->world_T_body.translation();
      const auto& board = std::get<Box>(table.shapes[0].geometry).size_m;
      EXPECT_LT(std::abs(local.x()), board.x() / 2) << "seed " << seed << ": " << body->name;
      EXPECT_LT(std::abs(local.y()), board.y() / 2) << "seed " << seed << ": " << body->name;
    }
  }
}

TEST(RandomWorld, ObjectsAreNotInsideEachOther) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const WorldSpec world = make(seed);
    std::vector<std::vector<Extent>> extents;
    for (const BodySpec& body : world.bodies) extents.push_back(extents_of(body));
    for (std::size_t i = 0; i < extents.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const bool loose =
            world.bodies[i].mobility == Mobility::kLoose || world.bodies[j].mobility == Mobility::kLoose;
        EXPECT_FALSE(loose && may_touch(extents[i], extents[j], 2e-3))
            << "seed " << seed << ": " << world.bodies[i].name << ", " << world.bodies[j].name;
      }
  }
}

TEST(RandomWorld, HoldsWhatItsParametersSay) {
  RandomWorldParams params;
  params.min_objects = 2;
  params.max_objects = 4;
  params.min_distractors = 1;
  params.max_distractors = 2;
  params.person = 0;
  std::map<std::string, int> labels;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const WorldSpec world = make(seed, params);
    int labelled = 0;
    const auto loose = loose_bodies(world);
    for (const BodySpec* body : loose) {
      ++labels[body->label];
      labelled += body->label.empty() ? 0 : 1;
    }
    EXPECT_GE(labelled, 1) << "seed " << seed;
    EXPECT_LE(labelled, 4) << "seed " << seed;
    EXPECT_LE(loose.size(), 6U) << "seed " << seed;
    EXPECT_TRUE(world.people.empty());
  }
  for (const char* label : {"cone", "cube", "sphere"}) EXPECT_GT(labels[label], 100) << label;
  EXPECT_GT(labels[""], 200);
}

TEST(RandomWorld, NamesAreUniqueAndTheRobotHasRoom) {
  for (const auto kind : {RandomWorldParams::Kind::kTable, RandomWorldParams::Kind::kFloor})
    for (std::uint64_t seed = 0; seed < kSeeds / 4; ++seed) {
      RandomWorldParams params;
      params.kind = kind;
      const WorldSpec world = make(seed, params);
      std::set<std::string> names;
      for (const BodySpec& body : world.bodies) {
        EXPECT_TRUE(names.insert(body.name).second) << "seed " << seed << ": " << body.name;
        if (body.name.rfind("floor", 0) == 0 || body.mobility == Mobility::kLoose) continue;
        for (const Shape& shape : body.shapes)
          if (const auto polygon =
                  outline(shape.geometry, body.world_T_body * shape.body_T_shape, 0.03, 1.5)) {
            EXPECT_GT(distance_m(*polygon, {0, 0}), 0.42) << "seed " << seed << ": " << body.name;
          }
      }
    }
}

TEST(RandomWorld, WorldsDiffer) {
  std::set<int> table_heights;
  std::set<int> lights;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const WorldSpec world = make(seed);
    table_heights.insert(static_cast<int>(heights_of(table_of(world)).high_m * 20));
    lights.insert(static_cast<int>(world.light.direct * 20));
  }
  EXPECT_GE(table_heights.size(), 8U);
  EXPECT_GE(lights.size(), 6U);
}

/// Most rooms of a floor can be reached through doorways that are wide enough for the robot's map.
TEST(RandomWorld, FloorsHaveRoomsThatCanBeReached) {
  RandomWorldParams params;
  params.kind = RandomWorldParams::Kind::kFloor;
  for (std::uint64_t seed = 0; seed < kSeeds / 10; ++seed) {
    const WorldSpec world = make(seed, params);
    const auto plan = floor_plan(world, 0.1, 0.1, 1.5);
    ASSERT_TRUE(plan) << plan.error().message;
    const auto count = [&](std::int8_t value) {
      return std::count(plan->data.begin(), plan->data.end(), value);
    };
    EXPECT_GT(count(kFreeCell), 0.7 * static_cast<double>(plan->data.size())) << "seed " << seed;
    EXPECT_LT(count(kUnknownCell), 0.02 * static_cast<double>(plan->data.size())) << "seed " << seed;
  }
}

TEST(RandomWorld, RefusesParametersOutOfRange) {
  RandomWorldParams params;
  params.min_objects = 5;
  params.max_objects = 4;
  EXPECT_FALSE(random_world(params, 1));
  params = {};
  params.max_distractors = 41;
  EXPECT_FALSE(random_world(params, 1));
  params = {};
  params.crowded = std::nan("");
  const auto world = random_world(params, 1);
  ASSERT_FALSE(world);
  EXPECT_NE(world.error().message.find("crowded"), std::string::npos);
}

}  // namespace
}  // namespace extperfc::simulate
