// Sensor and motion models against closed forms.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "localize/beam_model.hpp"
#include "localize/beams.hpp"
#include "localize/field_model.hpp"
#include "localize/map_model.hpp"
#include "localize/odometry.hpp"
#include "localize/refine.hpp"
#include "test/unit/localize/plan.hpp"

namespace extperfc::localize {
namespace {

OccupancyGrid random_map(std::size_t width, std::size_t height, double fraction, std::uint64_t seed) {
  Rng rng(seed);
  OccupancyGrid map;
  map.width = width;
  map.height = height;
  for (std::size_t i = 0; i < width * height; ++i) map.cells.push_back(rng.chance(fraction) ? 100 : 0);
  return map;
}

double nearest_obstacle_m(const OccupancyGrid& map, std::size_t column, std::size_t row) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t r = 0; r < map.height; ++r)
    for (std::size_t c = 0; c < map.width; ++c)
      if (map.at(c, r) == 100)
        nearest = std::min(nearest, std::hypot(static_cast<double>(c) - static_cast<double>(column),
                                               static_cast<double>(r) - static_cast<double>(row)));
  return nearest * map.resolution_m;
}

TEST(DistanceField, EqualsTheSearchOverAllObstacles) {
  struct Case {
    std::size_t width, height;
    double fraction, max_m;
  };
  for (const Case& c : {Case{37, 23, 0.02, 1}, Case{1, 40, 0.05, 2}, Case{40, 1, 0.05, 2},
                        Case{25, 25, 0.3, 0.5}, Case{30, 30, 0, 2}, Case{20, 30, 0.003, 0.07}}) {
    const auto map = random_map(c.width, c.height, c.fraction, 7);
    const DistanceField field(map, c.max_m);
    for (std::size_t row = 0; row < c.height; ++row)
      for (std::size_t column = 0; column < c.width; ++column) {
        const auto x = static_cast<float>((static_cast<double>(column) + 0.5) * map.resolution_m);
        const auto y = static_cast<float>((static_cast<double>(row) + 0.5) * map.resolution_m);
        const double truth = std::min(c.max_m, nearest_obstacle_m(map, column, row));
        ASSERT_NEAR(field.metres(field.at(x, y)), truth, 0.51 * c.max_m / 255) << column << " " << row;
      }
  }
}

TEST(DistanceField, AMarginAndThenNothing) {
  const auto map = random_map(20, 20, 1, 1);
  const DistanceField field(map, 2);
  EXPECT_EQ(field.at(0.5F, 0.5F), 0);
  EXPECT_NEAR(field.metres(field.at(1.525F, 0.5F)), 0.55, 0.004) << "0.525 m beyond the map's edge";
  EXPECT_NEAR(field.metres(field.at(0.5F, -0.525F)), 0.55, 0.004);
  for (const float outside : {-1.1F, 2.1F, -1e6F, 1e6F}) {
    EXPECT_EQ(field.at(outside, 0.5F), 255);
    EXPECT_EQ(field.at(0.5F, outside), 255);
  }
}

TEST(FieldModel, MeanOfTheBeamsLogLikelihoods) {
  OccupancyGrid map = random_map(100, 100, 0, 1);
  map.cells[50 * 100 + 50] = 100;
  const DistanceField field(map, 2);
  const FieldModel model(0.95, 0.05, 0.2, field);
  ParticleSet particle;
  particle.resize(1);
  particle.set(0, 2.525F, 2.525F, static_cast<float>(M_PI / 2));
  Beams beams;
  beams.x_m = {0, 0.3F, 0, 50};  // on the obstacle, 0.3 m above, 0.2 m to the left, outside
  beams.y_m = {0, 0, 0.2F, 0};
  std::vector<float> logs;
  model.mean_logs(field, beams, particle, logs);
  const auto of = [](double d) { return std::log(0.95 * std::exp(-d * d / (2 * 0.04)) + 0.05); };
  const double expected = (of(0) + of(0.3) + of(0.2) + std::log(0.05)) / 4;
  EXPECT_NEAR(logs[0], expected, 0.02) << "a byte of distance is 8 mm";
  model.mean_logs(field, beams, particle, logs, 2);
  EXPECT_NEAR(logs[0], (of(0) + of(0.2)) / 2, 0.02);
  model.mean_logs(field, Beams{}, particle, logs);
  EXPECT_EQ(logs[0], 0);
}

TEST(FieldModel, ManyBeamsAreSummedInBlocksAsOneByOne) {
  const auto plan = room();
  const auto map = plan.map();
  const DistanceField field(*map, 2);
  const FieldModel model(0.95, 0.05, 0.2, field);
  Rng rng(3);
  ParticleSet particles;
  particles.resize(20);
  for (std::size_t i = 0; i < 20; ++i)
    particles.set(i, static_cast<float>(rng.uniform(-1, 11)), static_cast<float>(rng.uniform(-1, 9)),
                  static_cast<float>(rng.uniform(-3, 3)));
  for (const int count : {2, 63, 64, 65, 129, 180}) {
    LocalizerParams params;
    params.laser_max_beams = count;
    const Beams beams = select_beams(plan.scan({5, 4, 0}, rng), params);
    std::vector<float> logs;
    model.mean_logs(field, beams, particles, logs);
    for (std::size_t p = 0; p < particles.size(); ++p) {
      double sum = 0;
      for (std::size_t i = 0; i < beams.ends(); ++i) {
        const Pose2 end =
            compose({particles.x[p], particles.y[p], particles.yaw[p]}, {beams.x_m[i], beams.y_m[i], 0});
        sum += model.log_of(field.at(static_cast<float>(end.x), static_cast<float>(end.y)));
      }
      // A beam that ends on the border of two cells may fall into either.
      ASSERT_NEAR(logs[p], sum / static_cast<double>(beams.ends()), 0.02) << count << " " << p;
    }
  }
}

TEST(Beams, EvenlySpacedOverTheRaysThatSaySomething) {
  LaserScan scan;
  scan.angle_min = 0;
  scan.angle_increment = 0.01;
  scan.range_min = 0.5;
  scan.range_max = 10;
  const float inf = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  scan.ranges = {nan, 0, -1, 0.4F, 1, 2, 3, inf, 11, 4, 5, -inf};
  LocalizerParams params;
  params.laser_max_beams = 3;
  Beams beams = select_beams(scan, params);
  ASSERT_EQ(beams.ends(), 3U);
  EXPECT_FLOAT_EQ(beams.range_m[0], 1);
  EXPECT_FLOAT_EQ(beams.range_m[1], 3);
  EXPECT_FLOAT_EQ(beams.range_m[2], 5);
  EXPECT_NEAR(beams.x_m[2], 5 * std::cos(0.1), 1e-5);
  EXPECT_NEAR(beams.y_m[2], 5 * std::sin(0.1), 1e-5);

  params.sensor_model = SensorModel::kBeam;
  params.laser_max_beams = 100;
  beams = select_beams(scan, params);
  EXPECT_EQ(beams.range_m.size(), 7U) << "with the two that met nothing";
  EXPECT_EQ(beams.ends(), 5U);
  EXPECT_FLOAT_EQ(beams.range_m[3], 10);

  params.laser_min_range = 1.5;
  params.laser_max_range = 4.5;
  beams = select_beams(scan, params);
  EXPECT_EQ(beams.range_m.size(), 6U);
  EXPECT_EQ(beams.ends(), 3U) << "2, 3 and 4 m";
  scan.ranges.assign(5, nan);
  EXPECT_TRUE(select_beams(scan, params).range_m.empty());
}

TEST(BeamModel, ProbabilitiesMakeOne) {
  const BeamModel model(LocalizerParams{});
  for (const double expected : {2.0, 5.0, 10.0, 11.0}) {
    double sum = model.likelihood(10, expected, 10);
    constexpr double kStep = 1e-3;
    for (double r = kStep / 2; r < 10; r += kStep) sum += kStep * model.likelihood(r, expected, 10);
    EXPECT_NEAR(sum, 1, 2e-3) << expected;
  }
}

TEST(BeamModel, PartsOfTheMixture) {
  LocalizerParams params;
  params.laser_z_hit = 0.6;
  params.laser_z_short = 0.2;
  params.laser_z_max = 0.1;
  params.laser_z_rand = 0.1;
  const BeamModel model(params);
  const double bell = 1 / (0.2 * std::sqrt(2 * M_PI));
  EXPECT_NEAR(model.likelihood(5, 5, 10), 0.6 * bell + 0.01, 1e-9);
  EXPECT_NEAR(model.likelihood(5.2, 5, 10), 0.6 * bell * std::exp(-0.5) + 0.01, 1e-9);
  EXPECT_NEAR(model.likelihood(1, 5, 10), 0.2 * 0.1 * std::exp(-0.1) / (1 - std::exp(-0.5)) + 0.01, 1e-9);
  EXPECT_NEAR(model.likelihood(10, 5, 10), 0.1, 1e-9);
  EXPECT_NEAR(model.likelihood(10, 10, 10), 0.7, 1e-9);
}

TEST(BeamModel, RaysEndAtTheWalls) {
  const auto plan = room();
  const auto map = plan.map();
  const DistanceField field(*map, 2);
  Rng rng(5);
  int far_off = 0;
  constexpr int kRays = 2000;
  for (int i = 0; i < kRays; ++i) {
    const double x = rng.uniform(3.5, 5.8);  // clear of the furniture
    const double y = rng.uniform(3.2, 5.2);
    const double angle = rng.uniform(-M_PI, M_PI);
    const double truth = std::min(6.0, plan.cast(x, y, angle));
    const float cast = cast_ray(field, static_cast<float>(x + 0.025), static_cast<float>(y + 0.025),
                                static_cast<float>(angle), 6);
    if (std::abs(cast - truth) > 0.1) ++far_off;  // grazing an edge
  }
  EXPECT_LT(far_off, kRays / 50);
  EXPECT_EQ(cast_ray(field, -5, 4, 0, 6), 6) << "from outside";
}

TEST(Refine, FindsThePoseToAFractionOfACell) {
  const auto plan = room();
  const auto map = plan.map();
  const DistanceField field(*map, 2);
  Rng rng(9);
  LocalizerParams params;
  params.laser_max_beams = 180;
  const Eigen::Matrix3d loose = 1e-3 * Eigen::Matrix3d::Identity();
  for (int i = 0; i < 20; ++i) {
    const Pose2 in_plan{rng.uniform(3.5, 5.5), rng.uniform(3, 5), rng.uniform(-3, 3)};
    const Beams beams = select_beams(plan.scan(in_plan, rng), params);
    const Pose2 truth = between(map->origin, in_plan);
    const Pose2 start =
        compose(truth, {rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1)});
    const Pose2 found = refine(field, beams, start, loose, kRefineSigma_m, 0.05).pose;
    EXPECT_LT(apart_m(found, truth), 0.01);
    EXPECT_LT(apart_rad(found, truth), 0.003);
    const Pose2 held =
        refine(field, beams, start, 1e9 * Eigen::Matrix3d::Identity(), kRefineSigma_m, 0.05).pose;
    EXPECT_LT(apart_m(held, start), 1e-3);
  }
}

struct Moments {
  Eigen::Vector3d mean{Eigen::Vector3d::Zero()};
  Eigen::Vector3d sigma{Eigen::Vector3d::Zero()};
};

/// Of the particles after one motion from a common start, in the start's frame.
Moments after(const LocalizerParams& params, const Pose2& motion, std::size_t count) {
  Rng rng(11);
  ParticleSet particles;
  particles.resize(count);
  const Pose2 start{3, -2, 0.7};
  for (std::size_t i = 0; i < count; ++i)
    particles.set(i, static_cast<float>(start.x), static_cast<float>(start.y), static_cast<float>(start.yaw));
  move_particles(params, motion, rng, particles);
  Moments moments;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const Pose2 moved = between(start, {particles.x[i], particles.y[i], particles.yaw[i]});
    const Eigen::Vector3d v(moved.x, moved.y, moved.yaw);
    moments.mean += v / static_cast<double>(count);
    squares += v.cwiseProduct(v) / static_cast<double>(count);
  }
  moments.sigma = (squares - moments.mean.cwiseProduct(moments.mean)).cwiseMax(0).cwiseSqrt();
  return moments;
}

constexpr std::size_t kSamples = 40000;
constexpr double kRelative = 0.02;  // sigma of n samples is good to 1 / sqrt(2 n) = 0.35 %: six of these

TEST(MapModel, AnObjectThatHasGoneCountsLessThanAWall) {
  Plan plan = room();
  Rng rng(4);
  LocalizerParams params;
  params.laser_max_beams = 180;
  const Pose2 truth{4.7, 3.2, 0};
  const Beams beams = select_beams(plan.scan(truth, rng), params);
  plan.box(5.2, 2.6, 5.5, 3.8);  // was there when the map was drawn
  const MapModel map_model(plan.map(), params);
  const Pose2 in_map = between(map_model.map->origin, truth);
  const double gone = map_model.agreement(beams, in_map);
  EXPECT_GT(gone, -0.7) << "a quarter to a third of the rays pass through it, onto walls";
  EXPECT_LT(gone, -0.2);
  const Pose2 wrong = compose(in_map, {1.5, 1.5, 0});
  EXPECT_LT(map_model.agreement(beams, wrong), gone - 0.3);
  EXPECT_LT(map_model.place_log(beams, wrong), map_model.place_log(beams, in_map) - 0.3);
}

TEST(Odometry, NoNoiseMeansTheMotionItself) {
  for (const auto model : {OdometryModel::kDifferential, OdometryModel::kOmni}) {
    LocalizerParams params;
    params.odometry_model = model;
    params.odom_alpha1 = params.odom_alpha2 = params.odom_alpha3 = params.odom_alpha4 = params.odom_alpha5 =
        0;
    for (const Pose2& motion :
         {Pose2{0.3, 0, 0}, Pose2{-0.2, 0.1, 0.5}, Pose2{0, 0, -1}, Pose2{0, 0.4, 0}, Pose2{}}) {
      const auto moments = after(params, motion, 10);
      EXPECT_NEAR(moments.mean.x(), motion.x, 1e-5);
      EXPECT_NEAR(moments.mean.y(), motion.y, 1e-5);
      EXPECT_NEAR(moments.mean.z(), motion.yaw, 1e-5);
    }
  }
}

TEST(Odometry, DifferentialMoments) {
  LocalizerParams params;
  params.odom_alpha1 = 0.01;
  params.odom_alpha2 = 0.02;
  params.odom_alpha3 = 0.03;
  params.odom_alpha4 = 0.04;
  const auto straight = after(params, {0.5, 0, 0}, kSamples);
  const double rotation_sigma = std::sqrt(0.02) * 0.5;  // each of two turns
  EXPECT_NEAR(straight.sigma.x(), std::sqrt(0.03) * 0.5, 0.05 * 0.5 * std::sqrt(0.03));
  EXPECT_NEAR(straight.sigma.y(), 0.5 * rotation_sigma, 0.05 * 0.5 * rotation_sigma);
  EXPECT_NEAR(straight.sigma.z(), std::sqrt(2.0) * rotation_sigma,
              kRelative * std::sqrt(2.0) * rotation_sigma);

  const auto rotation = after(params, {0, 0, 0.8}, kSamples);
  EXPECT_NEAR(rotation.mean.z(), 0.8, 5 * 0.08 / std::sqrt(double{kSamples}));
  EXPECT_NEAR(rotation.sigma.z(), std::sqrt(0.01) * 0.8, kRelative * 0.08);
  EXPECT_NEAR(std::hypot(rotation.sigma.x(), rotation.sigma.y()), std::sqrt(0.04) * 0.8, kRelative * 0.16);
}

TEST(Odometry, BackwardsIsNoRotation) {
  const LocalizerParams params;
  const auto forwards = motion_noise(params, {0.5, 0, 0});
  const auto backwards = motion_noise(params, {-0.5, 0, 0});
  EXPECT_NEAR(forwards.first_rotation_rad, backwards.first_rotation_rad, 1e-12);
  EXPECT_NEAR(forwards.translation_m, backwards.translation_m, 1e-12);
}

TEST(Odometry, OmniMoments) {
  LocalizerParams params;
  params.odometry_model = OdometryModel::kOmni;
  params.odom_alpha1 = 0.01;
  params.odom_alpha2 = 0.02;
  params.odom_alpha3 = 0.03;
  params.odom_alpha4 = 0.04;
  params.odom_alpha5 = 0.05;
  const auto moved = after(params, {0, 0.4, 0.2}, kSamples);  // to the left while turning
  const double along = std::sqrt(0.03 * 0.16 + 0.04 * 0.04);
  const double across = std::sqrt(0.04 * 0.04 + 0.05 * 0.16);
  const double turned = std::sqrt(0.01 * 0.04 + 0.02 * 0.16);
  EXPECT_NEAR(moved.mean.y(), 0.4, 5 * along / std::sqrt(double{kSamples}));
  EXPECT_NEAR(moved.sigma.y(), along, kRelative * along);
  EXPECT_NEAR(moved.sigma.x(), across, kRelative * across);
  EXPECT_NEAR(moved.sigma.z(), turned, kRelative * turned);
}

}  // namespace
}  // namespace extperfc::localize
