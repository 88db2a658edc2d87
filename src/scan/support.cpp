#include "scan/support.hpp"

#include <algorithm>
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

}  // namespace

std::optional<Surface> supported_surface(const Column& middle, const Column& left, const Column& right,
                                         const std::vector<float>& level, float support_m) {
  if (const auto own = by_own_rings(middle, level, support_m)) return own;
  return by_neighbours(middle, left, right, level, support_m);
}

}  // namespace extperfc::scan
