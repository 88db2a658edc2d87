#include "scan/support.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace extperfc::scan {

namespace {

constexpr float kOtherRing = 0.75F;          // levels that differ by more belong to two rings
constexpr std::ptrdiff_t kMaxCompared = 64;  // per point: bounded time for clouds of any kind

/// The mean of the points from `nearest` on that are no more than `support_m` behind it.
Surface surface_at(const Column& column, const ColumnPoint* nearest, float support_m, bool two_rings) {
  double sum = 0;
  int count = 0;
  for (const ColumnPoint* point = nearest;
       point != column.end() && point->range - nearest->range <= support_m; ++point, ++count)
    sum += static_cast<double>(point->range);
  return {static_cast<float>(sum / count), nearest->index, two_rings};
}

/// Two rings within one column.
std::optional<Surface> by_own_rings(const Column& column, const std::vector<float>& level, float support_m) {
  for (const ColumnPoint* nearest = column.begin(); nearest != column.end(); ++nearest)
    for (const ColumnPoint* other = nearest + 1; other != column.end() && other - nearest <= kMaxCompared &&
                                                 other->range - nearest->range <= support_m;
         ++other)
      if (std::abs(level[other->index] - level[nearest->index]) > kOtherRing)
        return surface_at(column, nearest, support_m, true);
  return std::nullopt;
}

/// What a point finds near to it in a column.
struct Company {
  bool other_ring{false};
  int same_ring{0};
};

void add_company(const ColumnPoint& point, const Column& column, const std::vector<float>& level,
                 float support_m, Company& company) {
  const auto* other = std::lower_bound(column.begin(), column.end(), point.range - support_m,
                                       [](const ColumnPoint& p, float range) { return p.range < range; });
  const auto* const last = other + std::min<std::ptrdiff_t>(column.end() - other, kMaxCompared);
  for (; other != last && other->range - point.range <= support_m; ++other) {
    if (std::abs(level[other->index] - level[point.index]) > kOtherRing)
      company.other_ring = true;
    else
      ++company.same_ring;
  }
}

/// Two rings with those of the neighbours; or else three points of one ring.
std::optional<Surface> by_neighbours(const Column& middle, const Column& left, const Column& right,
                                     const std::vector<float>& level, float support_m) {
  constexpr int kEnough = 3;
  const ColumnPoint* one_ring = nullptr;
  for (const ColumnPoint* point = middle.begin(); point != middle.end(); ++point) {
    Company company;
    add_company(*point, middle, level, support_m, company);
    if (left.first != middle.first) add_company(*point, left, level, support_m, company);
    if (right.first != middle.first) add_company(*point, right, level, support_m, company);
    if (company.other_ring) return surface_at(middle, point, support_m, true);
    if (!one_ring && company.same_ring >= kEnough) one_ring = point;
  }
  if (one_ring) return surface_at(middle, one_ring, support_m, false);
  return std::nullopt;
}

/// Mean of the largest of `count` standard normal numbers (Harter, "Expected values of normal order
/// statistics", Biometrika 48, 1961, table 1), linear in between; as of the last row for more.
float largest_of(std::ptrdiff_t count) {
  struct Row {
    float count;
    float mean;
  };
  constexpr std::array<Row, 15> kRows{{{1, 0},
                                       {2, 0.5642F},
                                       {3, 0.8463F},
                                       {4, 1.0294F},
                                       {5, 1.1630F},
                                       {6, 1.2672F},
                                       {8, 1.4236F},
                                       {10, 1.5388F},
                                       {15, 1.7359F},
                                       {20, 1.8675F},
                                       {30, 2.0428F},
                                       {40, 2.1608F},
                                       {50, 2.2491F},
                                       {70, 2.3774F},
                                       {100, 2.5076F}}};
  const float n = std::clamp(static_cast<float>(count), kRows.front().count, kRows.back().count);
  const auto* const upper =
      std::find_if(kRows.begin() + 1, kRows.end() - 1, [&](const Row& row) { return row.count >= n; });
  const Row& low = *(upper - 1);
  return low.mean + (n - low.count) / (upper->count - low.count) * (upper->mean - low.mean);
}

}  // namespace

float nearest_range(const Column& column, float noise_m) {
  constexpr float kSameSurface = 4;  // deviations
  const float nearest = column.first->range;
  const float last = nearest + kSameSurface * noise_m;
  const auto* const end = std::find_if(column.begin(), column.end(),
                                       [&](const ColumnPoint& point) { return point.range > last; });
  return nearest + noise_m * largest_of(end - column.begin());
}

std::optional<Surface> supported_surface(const Column& middle, const Column& left, const Column& right,
                                         const std::vector<float>& level, float support_m) {
  if (const auto own = by_own_rings(middle, level, support_m)) return own;
  return by_neighbours(middle, left, right, level, support_m);
}

}  // namespace extperfc::scan
