#include <algorithm>
#include <functional>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "mapping/matcher.hpp"
#include "test/support/planar_world.hpp"

namespace extperfc::mapping {
namespace {

const PosePrior kLoose{{}, 10.0, 10.0};

PosePrior loose(const Pose2& mean) {
  return {mean, kLoose.sigma_m, kLoose.sigma_rad};
}

std::function<double(const Pose2&)> score_of(const SurfaceMap& map, const ScanPoints& points) {
  return [&map, &points](const Pose2& pose) { return graded_fit(map, points, pose); };
}

/// What a scanner sees of a world, and a map of what it saw from some places before.
struct Surroundings {
  PlanarWorld world;
  PlanarScanner scanner;
  Rng rng{1};
  SurfaceMap map;

  explicit Surroundings(PlanarWorld walls, std::uint64_t seed = 1) : world(std::move(walls)), rng(seed) {}
  ScanPoints see(const Pose2& pose) { return scan_points(scanner.scan(world, pose, rng), {}); }
  void remember(const std::vector<Pose2>& poses) {
    for (const Pose2& pose : poses) map.add(see(pose), pose);
  }
};

TEST(Matcher, RecoversOffsetsInARoom) {
  Surroundings room(planar_room());
  room.remember({{-3, -1.5, 0}, {-2, -1.4, 0.1}, {-1, -1, 0.3}, {0, 0, 1.2}, {1, 0.5, 2.5}});
  double sum_m = 0;
  constexpr int kSeeds = 60;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    Rng rng(static_cast<std::uint64_t>(seed));
    const Pose2 truth{rng.uniform(-2.3, 2.3), rng.uniform(-1.5, 1.5), rng.uniform(-M_PI, M_PI)};
    const Pose2 start{truth.x + rng.uniform(-0.15, 0.15), truth.y + rng.uniform(-0.15, 0.15),
                      wrap_angle(truth.yaw + rng.uniform(-0.08, 0.08))};
    const auto found = match(room.map, room.see(truth), start, loose(start), 0.4);
    const double error_m = std::hypot(found.pose.x - truth.x, found.pose.y - truth.y);
    sum_m += error_m / kSeeds;
    // 1 cm of noise a point, hundreds of points: millimetres, and the map's own noise on top of that.
    EXPECT_LT(error_m, 0.02);
    EXPECT_LT(std::abs(wrap_angle(found.pose.yaw - truth.yaw)), 0.008);
    EXPECT_GT(found.fit, 0.8);
    EXPECT_GT(found.used, 100);
  }
  EXPECT_LT(sum_m, 0.007);
}

/// Walls bear on x and y: a narrow prior along x moves the match there and nowhere else.
TEST(Matcher, ThePriorMayBeNarrowAlongOneDirection) {
  Surroundings room(planar_room());
  room.remember({{-1, -1, 0.3}, {0, 0, 1.2}, {1, 0.5, 2.5}});
  const auto points = room.see({});
  constexpr double kOffM = 0.05;
  PosePrior prior = loose({kOffM, kOffM, 0});
  const auto free = match(room.map, points, {}, prior, 0.2);
  EXPECT_NEAR(free.pose.x, 0, 0.01);
  EXPECT_NEAR(free.pose.y, 0, 0.01);
  for (const Eigen::Vector2d& along : {Eigen::Vector2d(1, 0), Eigen::Vector2d(-1, 0)}) {
    prior.along = along;
    prior.sigma_along_m = 1e-4;
    const auto held = match(room.map, points, {}, prior, 0.2);
    EXPECT_NEAR(held.pose.x, kOffM, 0.001);
    EXPECT_NEAR(held.pose.y, 0, 0.015);
    EXPECT_NEAR(held.pose.yaw, 0, 0.01);
  }
}

TEST(Matcher, ThePriorHoldsAlongACorridor) {
  Surroundings corridor(planar_corridor());
  corridor.remember({{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}});
  const Pose2 truth{0.2, 0.1, 0.02};
  const Pose2 believed{0.5, 0, 0};
  const auto found = match(corridor.map, corridor.see(truth), believed, {believed, 0.05, 0.05}, 0.4);
  EXPECT_NEAR(found.pose.x, believed.x, 0.03) << "the position along the corridor is unconstrained";
  EXPECT_NEAR(found.pose.y, truth.y, 0.015) << "its walls constrain the direction across";
  EXPECT_NEAR(found.pose.yaw, truth.yaw, 0.005);
}

TEST(Matcher, ATightPriorIsBelieved) {
  Surroundings room(planar_room());
  room.remember({{0, 0, 0}});
  const Pose2 believed{0.05, 0, 0};
  const auto found = match(room.map, room.see({0, 0, 0}), believed, {believed, 1e-4, 1e-4}, 0.4);
  EXPECT_NEAR(found.pose.x, believed.x, 0.002);
  EXPECT_NEAR(found.pose.yaw, believed.yaw, 0.001);
}

TEST(Matcher, InformationOfACorridorIsWeakAlongIt) {
  Surroundings corridor(planar_corridor());
  std::vector<Pose2> drive;
  for (double x = -2.4; x <= 2.4; x += 0.3) drive.push_back({x, 0, 0});
  corridor.remember(drive);
  // Information is of x and y in the map's frame, whichever way the robot looks.
  for (const double yaw : {0.0, 0.02, 0.9, -2.0}) {
    const Pose2 pose{0.17, 0.05, yaw};
    const auto seen = evaluate(corridor.map, corridor.see(pose), pose);
    EXPECT_LT(seen.information(0, 0), 0.1 * seen.information(1, 1)) << yaw;
    EXPECT_LT((seen.information - seen.information.transpose()).cwiseAbs().maxCoeff(),
              1e-9 * seen.information.cwiseAbs().maxCoeff());
  }
  Surroundings room(planar_room());
  room.remember({{0, 0, 0}});
  const auto seen = evaluate(room.map, room.see({}), {});
  EXPECT_GT(seen.information(0, 0), 0.2 * seen.information(1, 1));
}

TEST(Matcher, MatchAlongFindsTheFeature) {
  PlanarWorld walls = planar_corridor();
  walls.add_box(0.8, 0.6, 1.2, 1);  // a cupboard, too small to pull a scan that is half a metre off
  Surroundings corridor(walls);
  corridor.remember({{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
  for (const double off : {0.6, -0.6, 0.8}) {
    SCOPED_TRACE(off);
    const Pose2 truth{0.3, 0.1, 0.05};
    const auto points = corridor.see(truth);
    const Pose2 believed{truth.x + off, 0, 0};
    const PosePrior prior{believed, 0.5, 0.1};
    const auto first = match(corridor.map, points, believed, prior, 0.3);
    ASSERT_GT(std::abs(first.pose.x - truth.x), 0.3) << "a plain match should stay where it began";
    const auto found =
        match_along(corridor.map, points, first, prior, 1.2, 0.3, score_of(corridor.map, points));
    EXPECT_NEAR(found.pose.x, truth.x, 0.06);
    EXPECT_NEAR(found.pose.y, truth.y, 0.02);
    EXPECT_NEAR(found.pose.yaw, truth.yaw, 0.01);
    EXPECT_GE(found.fit, first.fit);
  }
}

TEST(Matcher, MatchAlongKnowsWhatItDoesNotKnow) {
  Surroundings corridor(planar_corridor());
  corridor.remember({{-4, 0, 0}, {-2, 0, 0}, {0, 0, 0}, {2, 0, 0}, {4, 0, 0}});
  const auto points = corridor.see({});
  const auto first = match(corridor.map, points, {}, {{}, 0.3, 0.1}, 0.3);
  constexpr double kWindowM = 1.0;
  const auto found =
      match_along(corridor.map, points, first, {{}, 0.3, 0.1}, kWindowM, 0.3, score_of(corridor.map, points));
  const Eigen::Matrix3d covariance = (found.information + 1e-9 * Eigen::Matrix3d::Identity()).inverse();
  EXPECT_GT(std::sqrt(covariance(0, 0)), 0.5 * kWindowM) << "everything in the window looks alike";
  EXPECT_LT(std::sqrt(covariance(1, 1)), 0.05) << "across it still knows";
}

/// Points of a wall to the left of the base, 5 cm apart.
ScanPoints wall(float from_m, float to_m) {
  ScanPoints points;
  for (float x = from_m; x <= to_m; x += 0.05F) points.surface.push_back({{x, 1}, {0, -1}});
  return points;
}

TEST(Matcher, AgreementDoesNotGrowWithTheOverlap) {
  SurfaceMap map;
  map.add(wall(-10, 0), {});  // the rest of the wall was not seen
  const auto points = wall(-2, 2);
  const Pose2 truth;
  const Pose2 behind{-2, 0, 0};
  EXPECT_NEAR(graded_fit(map, points, truth), 0.5, 0.06);
  EXPECT_NEAR(graded_fit(map, points, behind), 1.0, 0.06) << "a plain fit pulls to what was seen";
  EXPECT_NEAR(agreement(map, points, truth).ratio(), agreement(map, points, behind).ratio(), 0.1)
      << "but for the points just behind the end";
  EXPECT_EQ(agreement(map, wall(20, 21), truth).ratio(), 0);
}

TEST(Matcher, MatchAlongLeavesRoomsAlone) {
  Surroundings room(planar_room());
  room.remember({{0, 0, 0}, {0.3, 0, 0}});
  const auto points = room.see({0.1, 0, 0});
  const auto first = match(room.map, points, {0.1, 0, 0}, loose({0.1, 0, 0}), 0.3);
  const auto along =
      match_along(room.map, points, first, loose({0.1, 0, 0}), 1.0, 0.3, score_of(room.map, points));
  EXPECT_EQ(along.pose.x, first.pose.x);
  EXPECT_EQ(along.pose.y, first.pose.y);
  EXPECT_EQ(along.information, first.information);
}

TEST(Matcher, EvaluateDoesNotMove) {
  Surroundings room(planar_room());
  room.remember({{0, 0, 0}, {-0.5, 0.2, 1}});
  const auto points = room.see({0.2, 0.1, 0.3});
  const Pose2 there{0.2, 0.1, 0.3};
  const auto right = evaluate(room.map, points, there);
  EXPECT_EQ(right.pose.x, there.x);
  EXPECT_EQ(right.pose.y, there.y);
  EXPECT_EQ(right.pose.yaw, there.yaw);
  EXPECT_GT(right.fit, 0.9);
  const Pose2 elsewhere{0.7, -0.5, 0.8};
  const auto wrong = evaluate(room.map, points, elsewhere);
  EXPECT_EQ(wrong.pose.x, elsewhere.x);
  EXPECT_LT(wrong.fit, 0.6);
}

TEST(Matcher, GradedFitIsBestWhereTheScanWasTaken) {
  Surroundings room(planar_room());
  room.remember({{0, 0, 0}, {-0.5, 0.2, 1}});
  const Pose2 truth{0.2, 0.1, 0.3};
  const auto points = room.see(truth);
  const double best = graded_fit(room.map, points, truth);
  EXPECT_GT(best, 0.85);
  EXPECT_LE(best, 1.0);
  double before = best;
  for (const double off : {0.05, 0.1, 0.15}) {
    const double there = graded_fit(room.map, points, {truth.x + off, truth.y - off, truth.yaw});
    EXPECT_LT(there, before);
    EXPECT_GE(there, 0);
    before = there;
  }
  EXPECT_EQ(graded_fit(room.map, {}, truth), 0);
  EXPECT_EQ(graded_fit(SurfaceMap{}, points, truth), 0);
}

TEST(Matcher, SearchNearFindsTheBasin) {
  Surroundings room(planar_room());
  room.remember({{0, 0, 0}, {-1, 0, 0}, {1, 0, 2}});
  int found_all = 0;
  constexpr int kSeeds = 20;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    Rng rng(static_cast<std::uint64_t>(seed));
    const Pose2 truth{rng.uniform(-1.5, 1.5), rng.uniform(-1, 1), rng.uniform(-M_PI, M_PI)};
    const double angle = rng.uniform(-M_PI, M_PI);
    const Pose2 centre{truth.x + 0.35 * std::cos(angle), truth.y + 0.35 * std::sin(angle),
                       wrap_angle(truth.yaw + (rng.chance(0.5) ? 0.25 : -0.25))};
    const auto points = room.see(truth);
    const Pose2 start = search_near(room.map, points, centre, 0.4, 0.3);
    EXPECT_LE(std::abs(start.x - centre.x), 0.4 + 1e-9);
    EXPECT_LE(std::abs(start.y - centre.y), 0.4 + 1e-9);
    EXPECT_LE(std::abs(wrap_angle(start.yaw - centre.yaw)), 0.3 + 1e-9);
    const auto found = match(room.map, points, start, loose(start), 0.25);
    const double error_m = std::hypot(found.pose.x - truth.x, found.pose.y - truth.y);
    if (error_m < 0.02 && std::abs(wrap_angle(found.pose.yaw - truth.yaw)) < 0.01) ++found_all;
  }
  EXPECT_EQ(found_all, kSeeds);
}

TEST(Matcher, NothingToMatch) {
  const SurfaceMap empty;
  Surroundings room(planar_room());
  const Pose2 start{1, 2, 0.5};
  const auto found = match(empty, room.see({}), start, {start, 0.1, 0.1}, 0.3);
  EXPECT_NEAR(found.pose.x, start.x, 1e-12);
  EXPECT_EQ(found.fit, 0);
  EXPECT_EQ(found.used, 0);
  room.remember({{0, 0, 0}});
  const auto blind = match(room.map, {}, start, {start, 0.1, 0.1}, 0.3);
  EXPECT_NEAR(blind.pose.yaw, start.yaw, 1e-12);
  EXPECT_EQ(blind.fit, 0);
  EXPECT_NEAR(search_near(empty, {}, start, 0.2, 0.1).x, start.x, 0.2 + 1e-9);
}

}  // namespace
}  // namespace extperfc::mapping
