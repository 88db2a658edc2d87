// A corridor around a block, 30 m x 20 m, closed into a loop.
#include <gtest/gtest.h>

#include "test/unit/mapping/mapper_drive.hpp"

namespace extperfc::mapping {
namespace {

constexpr double kBeyondM = 9.0;  // of the first side, driven again

PlanarScanner good_scanner() {
  PlanarScanner scanner;
  scanner.rays = 180;
  scanner.angle_increment = 2 * M_PI / 180;
  scanner.range_max = 8;
  scanner.sigma_m = 0.02;
  return scanner;
}

/// A third less of sight, less far, with twice the noise: tracking alone drifts with it.
PlanarScanner poor_scanner() {
  PlanarScanner scanner = good_scanner();
  scanner.rays = 121;
  scanner.angle_min = -60 * scanner.angle_increment;
  scanner.range_max = 5;
  scanner.sigma_m = 0.04;
  return scanner;
}

struct LoopResult {
  double odometry_end_m{0};
  double end_m{0};    ///< error of the last pose, live
  double final_m{0};  ///< the same after finish()
  double worst_m{0};  ///< anywhere on the path, after finish()
  double fit{0};      ///< mean over the scans
};

LoopResult map_loop(const PlanarScanner& scanner, std::uint64_t seed) {
  const auto drive = record_drive(planar_loop(), planar_loop_route(0.25, kBeyondM), seed, scanner);
  const std::size_t last = drive.scans.size() - 1;
  MapperParams params;
  params.seed = seed;
  Mapper mapper = make_mapper(params);
  LoopResult result;
  result.odometry_end_m = drive.error_m(drive.odometry[last], last);
  for (std::size_t i = 0; i <= last; ++i)
    result.fit += mapper.add(drive.scans[i], drive.odometry[i]).value().fit / static_cast<double>(last + 1);
  EXPECT_EQ(mapper.statistics().odometry_contradictions, 0U);
  result.end_m = drive.error_m(mapper.pose(), last);
  mapper.finish();
  EXPECT_TRUE(mapper.settled());
  const auto trajectory = mapper.trajectory();
  EXPECT_EQ(trajectory.size(), last + 1);
  result.final_m = drive.error_m(trajectory[last].pose, last);
  for (std::size_t i = 0; i <= last; ++i)
    result.worst_m = std::max(result.worst_m, drive.error_m(trajectory[i].pose, i));
  return result;
}

class LoopOfCorridors : public testing::TestWithParam<std::uint64_t> {};

TEST_P(LoopOfCorridors, IsClosedWithAGoodScanner) {
  const auto result = map_loop(good_scanner(), GetParam());
  ASSERT_GT(result.odometry_end_m, 1.0) << "odometry alone must not do";
  EXPECT_LT(result.end_m, 0.1);
  EXPECT_LT(result.final_m, 0.1);
  EXPECT_LT(result.worst_m, 0.3);
  EXPECT_GT(result.fit, 0.95);
}

INSTANTIATE_TEST_SUITE_P(Seeds, LoopOfCorridors, testing::Values(1, 2, 3, 4, 5));

/// Where a poor scanner sees nothing but bare walls, one stretch can pass for another: of five drives one may
/// be closed wrongly (seed 2 is), never more.
TEST(LoopOfCorridorsPoorScanner, IsClosedFourTimesOfFive) {
  int closed = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto result = map_loop(poor_scanner(), seed);
    EXPECT_GT(result.fit, 0.8) << "seed " << seed;
    // What tracking drifts in half a loop of 95 m, one part in a hundred, may remain far from the joint.
    if (result.end_m < 0.2 && result.final_m < 0.2 && result.worst_m < 0.8) ++closed;
  }
  EXPECT_GE(closed, 4);
}

}  // namespace
}  // namespace extperfc::mapping
