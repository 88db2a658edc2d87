#include <algorithm>
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "mapping/wide_search.hpp"
#include "test/support/planar_world.hpp"

namespace extperfc::mapping {
namespace {

constexpr double kStepM = static_cast<double>(SearchPyramid::kCellM);
constexpr int kAllNodes = 10'000'000;

SurfacePoint point_at(double x, double y) {
  return {Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)), Eigen::Vector2f::Zero()};
}

ScanPoints random_points(Rng& rng, int count, double half_width_m) {
  ScanPoints points;
  for (int i = 0; i < count; ++i)
    points.surface.push_back(
        point_at(rng.uniform(-half_width_m, half_width_m), rng.uniform(-half_width_m, half_width_m)));
  return points;
}

SurfaceMap map_of(const ScanPoints& points) {
  SurfaceMap map;
  map.add(points, {});
  return map;
}

/// Fraction of the points that fall on set cells of level 0 at a pose.
double score_at(const SearchPyramid& pyramid, const ScanPoints& points, const Pose2& pose) {
  int hits = 0;
  for (const auto& point : points.surface) {
    const double c = std::cos(pose.yaw);
    const double s = std::sin(pose.yaw);
    const auto p = point.position.cast<double>().eval();
    const auto column = static_cast<int>(std::floor((pose.x + c * p.x() - s * p.y()) / kStepM));
    const auto row = static_cast<int>(std::floor((pose.y + s * p.x() + c * p.y()) / kStepM));
    hits += pyramid.set(0, column, row) ? 1 : 0;
  }
  return static_cast<double>(hits) / static_cast<double>(points.surface.size());
}

TEST(SearchPyramid, ALevelIsTheUnionOfWhatAStepReaches) {
  Rng rng(1);
  const SearchPyramid pyramid(map_of(random_points(rng, 25, 1.5)));
  int set = 0;
  for (int level = 0; level < SearchPyramid::kLevels; ++level)
    for (int row = -45; row < 45; ++row)
      for (int column = -45; column < 45; ++column) {
        bool any = false;
        for (int dr = 0; dr < 1 << level && !any; ++dr)
          for (int dc = 0; dc < 1 << level && !any; ++dc) any = pyramid.set(0, column + dc, row + dr);
        ASSERT_EQ(pyramid.set(level, column, row), any) << level << " " << column << " " << row;
        if (any) ++set;
      }
  EXPECT_GT(set, 100);
}

TEST(SearchPyramid, EveryPointIsSetAndItsNeighbours) {
  Rng rng(2);
  const auto points = random_points(rng, 40, 3);
  const SearchPyramid pyramid(map_of(points));
  for (const auto& point : points.surface) {
    const auto column = static_cast<int>(std::floor(point.position.x() / SearchPyramid::kCellM));
    const auto row = static_cast<int>(std::floor(point.position.y() / SearchPyramid::kCellM));
    EXPECT_TRUE(pyramid.set(0, column, row));
  }
  EXPECT_FALSE(pyramid.set(0, 100, 0));
}

// If a bound were below any pose under it, branch and bound would miss the best pose now and then.
TEST(WideSearch, FindsWhatBruteForceFinds) {
  for (std::uint64_t seed = 1; seed <= 25; ++seed) {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const auto seen = random_points(rng, 40, 2);
    const SearchPyramid pyramid(map_of(seen));
    ScanPoints scan;  // half of it of the map, half of it elsewhere
    const Pose2 truth{rng.uniform(-0.8, 0.8), rng.uniform(-0.8, 0.8), rng.uniform(-0.1, 0.1)};
    for (int i = 0; i < 30; ++i) {
      const auto p = seen.surface[static_cast<std::size_t>(i)].position.cast<double>().eval();
      const Pose2 own = i % 2 == 0 ? compose(inverse(truth), {p.x(), p.y(), 0})
                                   : Pose2{rng.uniform(-2, 2), rng.uniform(-2, 2), 0};
      scan.surface.push_back(point_at(own.x, own.y));
    }
    const SearchWindow window{
        {rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), rng.uniform(-0.05, 0.05)}, 1.0, 0.12};
    double best = 0;
    for (int i = -4; i <= 4; ++i)
      for (int column = 0; column < 20; ++column)
        for (int row = 0; row < 20; ++row)
          best =
              std::max(best, score_at(pyramid, scan,
                                      {window.centre.x - 1.0 + column * kStepM,
                                       window.centre.y - 1.0 + row * kStepM, window.centre.yaw + 0.03 * i}));
    const auto found = search_wide(pyramid, scan, window, 0.05, kAllNodes);
    ASSERT_TRUE(found);
    // A point on the edge of a cell may fall to either side of it: shifts are whole cells there, sums here.
    constexpr double kOnePoint = 1.0 / 30;
    EXPECT_GE(found->score, best - kOnePoint - 1e-9);
    EXPECT_NEAR(found->score, score_at(pyramid, scan, found->pose), kOnePoint + 1e-9);
    EXPECT_FALSE(search_wide(pyramid, scan, window, found->score + 1e-6, kAllNodes)) << "none is better";
  }
}

TEST(WideSearch, FindsARoomFromAfar) {
  const PlanarWorld room = planar_room();
  const PlanarScanner scanner;
  Rng rng(3);
  SurfaceMap map;
  for (const Pose2& pose : {Pose2{0, 0, 0}, Pose2{-2, -1, 1}, Pose2{2, 0.5, 2}})
    map.add(scan_points(scanner.scan(room, pose, rng), {}), pose);
  const SearchPyramid pyramid(map);
  for (const Pose2& off : {Pose2{2.7, -2.2, 0.3}, Pose2{-3.1, 1.4, -0.35}, Pose2{0, 0, 0}}) {
    const Pose2 truth{0.4, -0.3, 0.7};
    const auto points = scan_points(scanner.scan(room, truth, rng), {});
    const SearchWindow window{{truth.x + off.x, truth.y + off.y, truth.yaw + off.yaw}, 4, 0.4};
    const auto found = search_wide(pyramid, points, window, 0.75, kAllNodes);
    ASSERT_TRUE(found);
    EXPECT_LT(std::hypot(found->pose.x - truth.x, found->pose.y - truth.y), 0.2);
    EXPECT_LT(std::abs(wrap_angle(found->pose.yaw - truth.yaw)), 0.05);
  }
}

TEST(WideSearch, StaysInsideItsWindow) {
  Rng rng(4);
  const auto seen = random_points(rng, 60, 2);
  const SearchPyramid pyramid(map_of(seen));
  for (int i = 0; i < 40; ++i) {
    const SearchWindow window{{rng.uniform(-3, 3), rng.uniform(-3, 3), rng.uniform(-1, 1)},
                              rng.uniform(0.1, 2),
                              rng.uniform(0, 0.3)};
    const auto found = search_wide(pyramid, seen, window, 0.01, kAllNodes);
    if (!found) continue;
    EXPECT_LE(std::abs(found->pose.x - window.centre.x), window.half_width_m + kStepM);
    EXPECT_LE(std::abs(found->pose.y - window.centre.y), window.half_width_m + kStepM);
    EXPECT_LE(std::abs(wrap_angle(found->pose.yaw - window.centre.yaw)), window.half_yaw_rad + 0.03);
  }
}

TEST(WideSearch, WindowsOnTheGridHoldTheirsAndTryTheSamePoses) {
  Rng rng(6);
  for (int i = 0; i < 200; ++i) {
    const SearchWindow window{
        {rng.uniform(-3, 3), rng.uniform(-3, 3), rng.uniform(-1, 1)}, rng.uniform(0, 2), rng.uniform(0, 0.3)};
    const SearchWindow wider = on_grid(window);
    for (const auto& [own, rounded] :
         {std::pair{window.centre.x, wider.centre.x}, std::pair{window.centre.y, wider.centre.y}}) {
      EXPECT_LE(rounded - wider.half_width_m, own - window.half_width_m + 1e-9);
      EXPECT_GE(rounded + wider.half_width_m, own + window.half_width_m - 1e-9);
      const double first_cell = (rounded - wider.half_width_m) / kStepM;
      EXPECT_NEAR(first_cell, std::round(first_cell), 1e-6);
    }
    EXPECT_LE(wider.centre.yaw - wider.half_yaw_rad, window.centre.yaw - window.half_yaw_rad + 1e-9);
    EXPECT_GE(wider.centre.yaw + wider.half_yaw_rad, window.centre.yaw + window.half_yaw_rad - 1e-9);
    EXPECT_LE(wider.half_width_m, window.half_width_m + 2 * kStepM);
  }
}

TEST(WideSearch, GivesUpAfterMaxNodes) {
  Rng rng(5);
  const auto seen = random_points(rng, 300, 10);
  const SearchPyramid pyramid(map_of(seen));
  const auto scan = random_points(rng, 80, 10);
  const SearchWindow window{{0, 0, 0}, 15, 0.6};
  EXPECT_FALSE(search_wide(pyramid, scan, window, 0.02, 1)) << "no bound may be opened after the first ones";
  ScanPoints itself = seen;
  itself.surface.resize(70);
  const auto found = search_wide(pyramid, itself, {{0.5, 0.2, 0}, 2, 0.1}, 0.9, kAllNodes);
  ASSERT_TRUE(found);
  EXPECT_GT(found->score, 0.9);
}

TEST(WideSearch, PeaksAreApartAndFallInScore) {
  Rng rng(7);
  const auto pattern = random_points(rng, 60, 1);
  ScanPoints twice = pattern;  // the same surroundings 3 m to the right, a third of them missing
  for (std::size_t i = 0; i < 40; ++i)
    twice.surface.push_back(point_at(static_cast<double>(pattern.surface[i].position.x()) + 3,
                                     static_cast<double>(pattern.surface[i].position.y())));
  const SearchPyramid pyramid(map_of(twice));
  const PeakOptions two{2, 1.0, 0.3, 1.0};
  const auto peaks = search_peaks(pyramid, pattern, {{1, 0.2, 0}, 4, 0.1}, 0.3, kAllNodes, two);
  ASSERT_EQ(peaks.size(), 2U);
  EXPECT_NEAR(peaks[0].pose.x, 0, 0.15);
  EXPECT_NEAR(peaks[1].pose.x, 3, 0.15);
  EXPECT_GT(peaks[0].score, peaks[1].score);
  PeakOptions like_the_best = two;
  like_the_best.within_best = 0.05;
  EXPECT_EQ(search_peaks(pyramid, pattern, {{1, 0.2, 0}, 4, 0.1}, 0.3, kAllNodes, like_the_best).size(), 1U);
}

TEST(WideSearch, NothingToFind) {
  const SearchPyramid empty{SurfaceMap{}};
  Rng rng(6);
  const auto scan = random_points(rng, 20, 1);
  EXPECT_FALSE(search_wide(empty, scan, {}, 0.1, kAllNodes));
  const SearchPyramid pyramid(map_of(scan));
  EXPECT_FALSE(search_wide(pyramid, {}, {}, 0.1, kAllNodes));
  EXPECT_FALSE(search_wide(pyramid, scan, {{50, 50, 0}, 2, 0.1}, 0.1, kAllNodes));
}

}  // namespace
}  // namespace extperfc::mapping
