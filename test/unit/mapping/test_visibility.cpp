#include <gtest/gtest.h>

#include "mapping/submap_cache.hpp"
#include "mapping/visibility.hpp"
#include "test/support/planar_world.hpp"

namespace extperfc::mapping {
namespace {

ScanPoints see(const PlanarWorld& world, const Pose2& pose, const PlanarScanner& scanner = {}) {
  Rng rng(1);
  return scan_points(scanner.scan(world, pose, rng), {});
}

/// Fraction of a circle about `centre` that is seen through.
double fraction_of_circle(const RangeProfile& profile, const Eigen::Vector2f& centre, float radius_m) {
  int seen = 0;
  constexpr int kPoints = 720;
  for (int i = 0; i < kPoints; ++i) {
    const float angle = (static_cast<float>(i) + 0.5F) * 2 * static_cast<float>(M_PI) / kPoints;
    if (profile.sees_through(centre + radius_m * Eigen::Vector2f(std::cos(angle), std::sin(angle)))) ++seen;
  }
  return static_cast<double>(seen) / kPoints;
}

TEST(Visibility, TheSpaceBeforeAWallIsFreeAndTheWallIsNot) {
  // The nearest object in the room is 2.2 m away from its middle, the farthest 5 m.
  const RangeProfile profile(see(planar_room(), {}));
  EXPECT_GT(fraction_of_circle(profile, {0, 0}, 0.5F), 0.7) << "directions between two rays are unknown";
  EXPECT_GT(fraction_of_circle(profile, {0, 0}, 1.8F), 0.7);
  EXPECT_EQ(fraction_of_circle(profile, {0, 0}, 5.5F), 0) << "behind the walls";
  for (const auto& point : see(planar_room(), {}).surface) EXPECT_FALSE(profile.sees_through(point.position));
}

TEST(Visibility, DirectionsWithoutReturnsSayNothing) {
  PlanarScanner scanner;
  scanner.rays = 180;
  scanner.angle_min = -M_PI / 2;
  const RangeProfile profile(see(planar_room(), {}, scanner));
  int behind = 0;
  int ahead = 0;
  for (float y = -1.5F; y < 1.5F; y += 0.02F) {
    if (profile.sees_through({-0.5F, y})) ++behind;
    if (profile.sees_through({0.5F, y})) ++ahead;
  }
  EXPECT_EQ(behind, 0);
  EXPECT_GT(ahead, 100);
  EXPECT_EQ(fraction_of_circle(RangeProfile{ScanPoints{}}, {0, 0}, 0.1F), 0);
}

TEST(Visibility, IsSeenFromTheScanner) {
  PlanarScanner scanner;
  scanner.base_T_sensor = {1, 0.5, 2.0};
  const RangeProfile profile(see(planar_room(), {-1, -0.5, 0}, scanner));  // the scanner stands in the middle
  EXPECT_GT(fraction_of_circle(profile, {1, 0.5F}, 1.8F), 0.7);
  EXPECT_EQ(fraction_of_circle(profile, {1, 0.5F}, 5.5F), 0);
}

TEST(Visibility, ScansOfOnePlaceDoNotContradict) {
  const PlanarWorld room = planar_room();
  const Pose2 a{0, 0, 0.3};
  const Pose2 b{0.8, -0.6, 2.0};
  const auto seen_a = see(room, a);
  const auto seen_b = see(room, b);
  EXPECT_LT(fraction_in_free_space(RangeProfile(seen_a), seen_b, between(a, b)), 0.02);
  EXPECT_LT(fraction_in_free_space(RangeProfile(seen_b), seen_a, between(b, a)), 0.02);
  EXPECT_GT(fraction_in_free_space(RangeProfile(seen_a), seen_b, compose(between(a, b), {1.2, 0.5, 0})), 0.1)
      << "walls cannot stand where the other looked through";
  EXPECT_EQ(fraction_in_free_space(RangeProfile(seen_a), {}, {}), 0);
  SurfaceMap map;
  EXPECT_EQ(fraction_seen_through(RangeProfile(seen_b), map, b, 8), 0);
  for (int i = 0; i < 3; ++i) map.add(seen_a, a);
  EXPECT_LT(fraction_seen_through(RangeProfile(seen_b), map, b, 8), 0.02);
  EXPECT_GT(fraction_seen_through(RangeProfile(seen_b), map, compose(b, {1.2, 0.5, 0}), 8), 0.1);
}

TEST(Visibility, OnlySurfacesWithinTheRadiusCount) {
  const auto seen = see(planar_room(), {});
  SurfaceMap map;
  ScanPoints phantom;  // in the middle of the room, where nothing is
  for (int i = 0; i < 20; ++i)
    phantom.surface.push_back({{0.5F + 0.05F * static_cast<float>(i), 0.4F}, {0, -1}});
  map.add(phantom, {});
  map.add(phantom, {});
  const RangeProfile profile(seen);
  EXPECT_GT(fraction_seen_through(profile, map, {}, 3), 0.7);
  EXPECT_EQ(fraction_seen_through(profile, map, {}, 0.3), 0);
}

TEST(Visibility, APlaceContradictsAScanOfAnother) {
  PlanarWorld other = planar_room();
  other.add_box(0.5, -1.6, 1.5, -0.6);
  std::vector<KeyFrame> frames;
  std::vector<Pose2> poses;
  for (int i = 0; i < 6; ++i) {
    poses.push_back({-1 + 0.3 * i, 0.5, 0.2 * i});
    frames.push_back({static_cast<std::size_t>(i), 0.3 * i, see(planar_room(), poses.back())});
  }
  SubmapCache cache;
  const Submap& submap = cache.at(3, 6, frames, poses);
  const Pose2 pose{0.2, 0.3, 1.0};
  const auto same = see(planar_room(), pose);
  const auto strange = see(other, pose);
  const Pose2 submap_T_base = between(poses[3], pose);
  const double right = contradictions(submap, same, RangeProfile(same), submap_T_base);
  const double wrong = contradictions(submap, strange, RangeProfile(strange), submap_T_base);
  EXPECT_LT(right, 0.02);
  EXPECT_GT(wrong, 0.05) << "a cupboard stands where the submap was free";
}

}  // namespace
}  // namespace extperfc::mapping
