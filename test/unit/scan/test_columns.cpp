// Points sorted by ray and range, against the standard library's stable sort.
#include <algorithm>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "scan/columns.hpp"

namespace extperfc::scan {
namespace {

struct Point {
  std::size_t ray;
  float range;
};

/// Sorts with `columns`, which may have been used before.
void expect_sorted(const std::vector<Point>& points, std::size_t rays, Columns& columns) {
  columns.clear(rays, points.size());
  std::vector<std::vector<std::uint32_t>> expected(rays);
  for (std::size_t i = 0; i < points.size(); ++i) {
    columns.add(points[i].ray, points[i].range, i);
    expected[points[i].ray].push_back(static_cast<std::uint32_t>(i));
  }
  columns.sort();
  for (std::size_t ray = 0; ray < rays; ++ray) {
    std::stable_sort(expected[ray].begin(), expected[ray].end(),
                     [&](std::uint32_t a, std::uint32_t b) { return points[a].range < points[b].range; });
    const Column column = columns.column(ray);
    ASSERT_EQ(column.size(), expected[ray].size()) << "ray " << ray;
    for (std::size_t k = 0; k < column.size(); ++k) {
      EXPECT_EQ(column.first[k].index, expected[ray][k]) << "ray " << ray << ", place " << k;
      EXPECT_EQ(column.first[k].range, points[column.first[k].index].range);
    }
  }
}

std::vector<Point> random_points(std::size_t count, std::size_t rays, double nearest, double farthest) {
  Rng rng(3);
  std::vector<Point> points;
  for (std::size_t i = 0; i < count; ++i)
    points.push_back({static_cast<std::size_t>(rng.uniform(0, static_cast<double>(rays))) % rays,
                      static_cast<float>(rng.uniform(nearest, farthest))});
  return points;
}

TEST(Columns, AreInTheOrderOfRanges) {
  Columns columns;
  expect_sorted(random_points(30'000, 900, 0.1, 130), 900, columns);
  expect_sorted(random_points(100, 3, 0, 1e6), 3, columns);
  expect_sorted(random_points(20'000, 2, 0.5, 30), 2, columns);
  expect_sorted({}, 5, columns);
  expect_sorted({{4, 2.0F}}, 5, columns);
}

TEST(Columns, RangesThatHardlyDifferAreInOrder) {
  Columns columns;
  auto points = random_points(5'000, 7, 5, 5.000'01);  // some twenty floats
  expect_sorted(points, 7, columns);
  points.push_back({3, 0.0F});
  points.push_back({3, 1e6F});  // the passes by range now tell fewer of them apart
  expect_sorted(points, 7, columns);
}

TEST(Columns, EqualRangesKeepTheOrderOfPoints) {
  Columns columns;
  expect_sorted(std::vector<Point>(10'000, {1, 3.0F}), 2, columns);
  expect_sorted({{0, 0.0F}, {0, std::numeric_limits<float>::denorm_min()}, {0, 0.0F}}, 1, columns);
}

TEST(Columns, ShrunkOnesKeepTheirFirstPoints) {
  Columns columns;
  columns.clear(2, 3);
  columns.add(1, 3, 0);
  columns.add(1, 1, 1);
  columns.add(1, 2, 2);
  columns.sort();
  columns.shrink(1, 2);
  ASSERT_EQ(columns.column(1).size(), 2U);
  EXPECT_EQ(columns.column(1).first->index, 1U);
  EXPECT_TRUE(columns.column(0).empty());
}

}  // namespace
}  // namespace extperfc::scan
