// KLD bound, resampling, weights, clusters.
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "localize/free_space.hpp"
#include "localize/kld.hpp"
#include "localize/pose_bins.hpp"
#include "localize/recovery.hpp"
#include "localize/scan_search.hpp"
#include "localize/weights.hpp"
#include "test/unit/localize/plan.hpp"

namespace extperfc::localize {
namespace {

double sum_of(const std::vector<float>& weights) {
  return std::accumulate(weights.begin(), weights.end(), 0.0);
}

std::vector<float> random_weights(std::size_t count, Rng& rng) {
  std::vector<float> weights(count);
  for (float& w : weights) w = static_cast<float>(rng.uniform(0, 1));
  const double sum = sum_of(weights);
  for (float& w : weights) w = static_cast<float>(w / sum);
  return weights;
}

TEST(Kld, Quantiles) {
  EXPECT_NEAR(normal_quantile(0.5), 0, 1e-9);
  EXPECT_NEAR(normal_quantile(0.975), 1.959963985, 1e-8);
  EXPECT_NEAR(normal_quantile(0.99), 2.326347874, 1e-8);
  EXPECT_NEAR(normal_quantile(0.01), -2.326347874, 1e-8);
  EXPECT_NEAR(normal_quantile(0.999999), 4.753424309, 1e-7);
}

TEST(Kld, TheBoundIsAChiSquareQuantile) {
  // 0.99 quantiles of the chi-square distribution from tables; n = quantile / (2 error).
  struct Case {
    std::size_t degrees;
    double quantile;
  };
  for (const Case& c : {Case{5, 15.086}, Case{10, 23.209}, Case{30, 50.892}, Case{100, 135.807}}) {
    const auto n = static_cast<double>(kld_sample_size(c.degrees + 1, 0.01, normal_quantile(0.99)));
    EXPECT_NEAR(n, c.quantile / 0.02, 0.01 * c.quantile / 0.02) << c.degrees;
  }
  EXPECT_EQ(kld_sample_size(0, 0.01, 2), 1U);
  EXPECT_EQ(kld_sample_size(1, 0.01, 2), 1U);
}

TEST(Kld, TheCountFollowsTheBinsThatAreMet) {
  Rng rng(1);
  const double z = normal_quantile(0.99);
  for (const std::size_t bins : {2U, 10U, 50U}) {
    std::vector<std::uint32_t> bin_of(5000);
    for (std::size_t i = 0; i < bin_of.size(); ++i) bin_of[i] = static_cast<std::uint32_t>(i % bins);
    const std::vector<float> weights(bin_of.size(), 1.0F / 5000);
    EXPECT_EQ(kld_count(weights, bin_of, bins, 10, 100000, 0.02, z, rng), kld_sample_size(bins, 0.02, z));
    EXPECT_EQ(kld_count(weights, bin_of, bins, 10, 20, 0.02, z, rng), 20U) << "never more than max_count";
    EXPECT_EQ(kld_count(weights, bin_of, bins, 99999, 100000, 0.02, z, rng), 99999U)
        << "nor less than min_count";
    EXPECT_EQ(kld_count(weights, bin_of, bins, 70, 70, 0.02, z, rng), 70U);
  }
}

TEST(Resampling, EveryParticleAsOftenAsItsWeightSays) {
  Rng rng(2);
  const auto weights = random_weights(200, rng);
  for (const std::size_t count : {50U, 200U, 1000U}) {
    const auto drawn = sample_systematic(weights, count, rng);
    ASSERT_EQ(drawn.size(), count);
    ASSERT_TRUE(std::is_sorted(drawn.begin(), drawn.end()));
    std::vector<double> times(weights.size(), 0);
    for (const auto i : drawn) ++times[i];
    for (std::size_t i = 0; i < weights.size(); ++i)
      ASSERT_LE(std::abs(times[i] - weights[i] * static_cast<double>(count)), 1.0 + 1e-3) << i;
  }
}

TEST(Resampling, Unbiased) {
  Rng rng(3);
  const auto weights = random_weights(20, rng);
  constexpr int kRounds = 20000;
  std::vector<double> times(weights.size(), 0);
  for (int round = 0; round < kRounds; ++round)
    for (const auto i : sample_systematic(weights, 7, rng)) ++times[i];
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double p = weights[i] * 7;  // mean number of times per round, below one here
    ASSERT_LT(p, 1);
    EXPECT_NEAR(times[i] / kRounds, p, 5 * std::sqrt(p * (1 - p) / kRounds)) << i;
  }
}

TEST(Weights, SumToOneWhateverTheLikelihoods) {
  Rng rng(4);
  for (const double scale : {1e-3, 1.0, 1e3, 1e6}) {
    auto weights = random_weights(300, rng);
    std::vector<float> logs(300);
    for (float& log : logs) log = static_cast<float>(-scale * rng.uniform(0, 1));
    reweight(weights, logs, 60);
    EXPECT_NEAR(sum_of(weights), 1, 1e-4);
    for (const float w : weights) ASSERT_TRUE(std::isfinite(w) && w >= 0);
  }
  std::vector<float> weights{1, 0};
  reweight(weights, {-1e6F, 0}, 60);
  EXPECT_NEAR(sum_of(weights), 1, 1e-6) << "all the weight lay where the scan cannot be";
}

TEST(Weights, BayesRule) {
  std::vector<float> weights{0.5F, 0.3F, 0.2F};
  reweight(weights, {std::log(0.1F), std::log(0.2F), std::log(0.4F)}, 2);
  const double sum = 0.5 * 0.01 + 0.3 * 0.04 + 0.2 * 0.16;
  EXPECT_NEAR(weights[0], 0.005 / sum, 1e-6);
  EXPECT_NEAR(weights[1], 0.012 / sum, 1e-6);
  EXPECT_NEAR(weights[2], 0.032 / sum, 1e-6);
}

TEST(Weights, TemperingLeavesEnoughParticles) {
  Rng rng(5);
  std::vector<float> logs(1000);
  for (float& log : logs) log = static_cast<float>(-rng.uniform(0, 3));
  const std::vector<float> equal(1000, 1e-3F);
  const double exponent = tempered_exponent(equal, logs, 60, 100);
  EXPECT_LT(exponent, 60);
  auto weights = equal;
  reweight(weights, logs, exponent);
  EXPECT_GE(effective_count(weights), 99);
  EXPECT_LT(effective_count(weights), 120) << "and no blunter than needed";
  EXPECT_EQ(tempered_exponent(equal, std::vector<float>(1000, -1.0F), 60, 100), 60);
}

TEST(Clusters, TheHeaviestOneWithItsMeanAcrossPi) {
  Rng rng(6);
  ParticleSet particles;
  particles.resize(1000);
  for (std::size_t i = 0; i < 1000; ++i) {
    const bool first = i < 700;
    particles.set(i, static_cast<float>((first ? -3 : 4) + rng.normal(0, 0.1)),
                  static_cast<float>(2 + rng.normal(0, 0.2)),
                  static_cast<float>(wrap_angle((first ? M_PI : 1) + rng.normal(0, 0.05))));
    particles.weight[i] = 1e-3F;
  }
  const PoseBins bins(particles);
  const auto estimate = heaviest_cluster(particles, bins);
  EXPECT_NEAR(estimate.cluster_weight, 0.7, 0.02);
  EXPECT_NEAR(estimate.pose.x, -3, 5 * 0.1 / std::sqrt(700));
  EXPECT_NEAR(estimate.pose.y, 2, 5 * 0.2 / std::sqrt(700));
  EXPECT_LT(apart_rad(estimate.pose, {0, 0, M_PI}), 5 * 0.05 / std::sqrt(700));
  EXPECT_NEAR(std::sqrt(estimate.covariance(0, 0)), 0.1, 0.02);
  EXPECT_NEAR(std::sqrt(estimate.covariance(1, 1)), 0.2, 0.03);
  EXPECT_NEAR(std::sqrt(estimate.covariance(2, 2)), 0.05, 0.01);
  EXPECT_EQ(bins.bin_of().size(), 1000U);
}

TEST(Clusters, SameYawApartInPositionAndTheReverse) {
  ParticleSet particles;
  particles.resize(3);
  particles.set(0, 0.2F, 0.2F, 0.01F);
  particles.set(1, 0.2F, 0.2F, 1.5F);
  particles.set(2, 5.2F, 0.2F, 0.01F);
  particles.make_weights_equal();
  const PoseBins bins(particles);
  EXPECT_EQ(bins.bins(), 3U);
  EXPECT_NEAR(heaviest_cluster(particles, bins).cluster_weight, 1.0 / 3, 1e-6);
}

TEST(Recovery, FractionIsZeroUntilTheFitFalls) {
  Recovery recovery(0.001, 0.1);
  for (int i = 0; i < 500; ++i) {
    recovery.add(0.9);
    ASSERT_EQ(recovery.fraction(), 0);
  }
  for (int i = 0; i < 20; ++i) recovery.add(0.3);
  const double fast = 0.3 + 0.6 * std::pow(0.9, 20);
  EXPECT_NEAR(recovery.fraction(), 1 - fast / recovery.usual(), 1e-6);
  EXPECT_GT(recovery.usual(), 0.87);
  for (int i = 0; i < 60; ++i) recovery.add(0.9);
  EXPECT_EQ(recovery.fraction(), 0);

  Recovery off(0, 0.1);
  for (int i = 0; i < 20; ++i) off.add(0.01);
  EXPECT_EQ(off.fraction(), 0);
}

TEST(FreeSpace, UniformOverFreeCellsManyOrFew) {
  const auto map = std::make_shared<OccupancyGrid>();
  map->width = 50;
  map->height = 40;
  for (const std::size_t every : {2U, 60U}) {  // found by guessing, and by the list
    map->cells.assign(2000, OccupancyGrid::kUnknown);
    std::size_t cells = 0;
    for (std::size_t i = 0; i < 2000; i += every, ++cells) map->cells[i] = OccupancyGrid::kFree;
    const FreeSpace space(map);
    ASSERT_EQ(space.cells(), cells);
    Rng rng(7);
    const std::size_t draws = 100 * cells;
    std::vector<int> times(2000, 0);
    for (std::size_t i = 0; i < draws; ++i) {
      const auto point = space.draw(rng);
      const auto cell = map->cell_of(point.x_m, point.y_m);
      ASSERT_TRUE(cell);
      ++times[cell->row * 50 + cell->column];
    }
    for (std::size_t i = 0; i < 2000; ++i) {
      if (i % every != 0)
        ASSERT_LE(times[i], 1) << "single precision on a cell's border";
      else
        ASSERT_NEAR(times[i], 100, 60) << i;  // six standard deviations
    }
  }
}

TEST(ScanSearch, FindsThePoseThatTheScanShows) {
  const auto plan = room();
  const LocalizerParams params;
  const MapModel map_model(plan.map(), params);
  Rng rng(8);
  for (int i = 0; i < 5; ++i) {
    const Pose2 truth{rng.uniform(3.5, 5.8), rng.uniform(3.2, 5.2), rng.uniform(-3, 3)};
    const auto poses = search_scan(map_model, select_beams(plan.scan(truth, rng), params), 20000, 200, rng);
    ASSERT_EQ(poses.size(), 200U);
    EXPECT_NEAR(sum_of(poses.weight), 1, 1e-4);
    int near = 0;
    for (std::size_t p = 0; p < poses.size(); ++p) {
      const Pose2 pose{poses.x[p], poses.y[p], poses.yaw[p]};
      near += apart_m(pose, truth) < 0.5 && apart_rad(pose, truth) < 0.35;
    }
    EXPECT_GT(near, 40) << "uniform draws would give 0.1";
  }
  EXPECT_EQ(search_scan(map_model, Beams{}, 1000, 50, rng).size(), 50U) << "without end points";
}

}  // namespace
}  // namespace extperfc::localize
