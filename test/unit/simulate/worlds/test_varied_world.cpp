// Worlds for difficult training images.

#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/world/shape_extent.hpp"

#include "simulate/worlds/varied_objects.hpp"
#include "simulate/worlds/varied_world.hpp"

namespace extperfc::simulate {
namespace {

constexpr std::uint64_t kSeeds = 60;

TEST(VariedWorld, TheSameSeedGivesTheSameWorld) {
  for (const std::uint64_t seed : {3U, 4U}) {
    const WorldSpec one = varied_world(seed);
    const WorldSpec other = varied_world(seed);
    ASSERT_EQ(one.bodies.size(), other.bodies.size());
    for (std::size_t i = 0; i < one.bodies.size(); ++i) {
      EXPECT_EQ(one.bodies[i].name, other.bodies[i].name);
      EXPECT_TRUE(one.bodies[i].world_T_body.isApprox(other.bodies[i].world_T_body, 0));
    }
    EXPECT_NE(one.light.direct, varied_world(seed + 100).light.direct);
  }
}

TEST(VariedWorld, HoldsEveryClassAndOthersAboveTheFloor) {
  std::map<std::string, int> labels;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed)
    for (const BodySpec& body : varied_world(seed).bodies) {
      ++labels[body.label];
      if (!body.label.empty()) {
        const double low = vertical_extent(body.shapes, body.world_T_body).low_m;
        EXPECT_GT(low, -1e-6) << body.name << " of world " << seed;
      }
    }
  for (const std::string label : {"", "cone", "cube", "sphere", "egg"})
    EXPECT_GT(labels[label], static_cast<int>(kSeeds) / 2) << label;
}

/// A label is a promise about the shape: cubes have equal edges, look-alikes are never called what they are
/// not.
TEST(VariedObjects, LabelsTellTheShape) {
  Rng rng(5);
  std::set<std::string> others;
  for (int i = 0; i < 400; ++i) {
    const ObjectModel target = varied_target(rng);
    const Geometry& shape = target.shapes.at(0).geometry;
    if (target.label == "cube") {
      const auto& size = std::get<Box>(shape).size_m;
      EXPECT_DOUBLE_EQ(size.minCoeff(), size.maxCoeff());
    } else if (target.label == "sphere") {
      EXPECT_TRUE(std::holds_alternative<Sphere>(shape));
    } else {
      EXPECT_EQ(target.label, "cone");
      EXPECT_TRUE(std::holds_alternative<Cone>(shape));
    }
    const std::string other = look_alike(rng).label;
    EXPECT_TRUE(other != "cone" && other != "cube" && other != "sphere" && !other.empty()) << other;
    others.insert(other);
  }
  EXPECT_EQ(others.size(), 14U);
}

}  // namespace
}  // namespace extperfc::simulate
