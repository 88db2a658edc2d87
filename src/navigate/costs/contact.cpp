#include <algorithm>
#include <cmath>
#include <cstring>

#include "extperfc/navigate/footprint.hpp"

#include "navigate/costs/row_spans.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kSqrt2 = 1.4142135623730951;

/// Whether one of 8 cells is lethal or unknown.
bool holds_blocked(const Cost* cells) {
  constexpr std::uint64_t kLow = 0x0101010101010101;
  std::uint64_t packed = 0;
  std::memcpy(&packed, cells, sizeof packed);
  const std::uint64_t differs = (packed & (kLethalCost * kLow)) ^ (kLethalCost * kLow);  // 0 in such a byte
  return ((differs - kLow) & ~differs & (0x80 * kLow)) != 0;
}

/// The same for `count` cells.
bool holds_blocked(const Cost* cells, std::size_t count) {
  constexpr std::size_t kBlock = 8;
  if (count < kBlock) return std::any_of(cells, cells + count, [](Cost cost) { return cost >= kLethalCost; });
  for (std::size_t i = 0; i + kBlock < count; i += kBlock)
    if (holds_blocked(cells + i)) return true;
  return holds_blocked(cells + count - kBlock);  // may repeat some
}

/// What `count` cells side by side hold.
Contact worst_of(const Cost* cells, std::size_t count) {
  if (!holds_blocked(cells, count)) return Contact::kFree;
  return std::memchr(cells, kLethalCost, count) != nullptr ? Contact::kObstacle : Contact::kUnknown;
}

/// A lethal cell under the footprint is at most the circumscribed radius from the base; the middles of both
/// cells at most a cell's diagonal more.
bool surely_free(const CostGrid& costs, const Footprint& footprint, Cost centre) {
  if (costs.may_hold_unknown) return false;
  const double distance_m = footprint.circumscribed_radius_m() + kSqrt2 * costs.resolution_m;
  return distance_m <= costs.inflation.radius_m && centre < costs.inflation.cost_at(distance_m);
}

/// Adds what a convex polygon covers.
void cover(const CostGrid& costs, const Polygon& part_m, const ToCells& to_cells, Contact& contact) {
  const Bounds bounds(part_m, to_cells);
  if (!bounds.inside(costs)) contact = std::max(contact, Contact::kUnknown);
  if (!bounds.is_finite()) return;
  visit_rows(costs, part_m, to_cells, bounds, [&](int row, int begin, int end) {
    contact = std::max(
        contact, worst_of(&costs.cells[costs.index({begin, row})], static_cast<std::size_t>(end - begin)));
    return contact != Contact::kObstacle;
  });
}

}  // namespace

Contact contact(const CostGrid& costs, const Footprint& footprint, const Pose2& grid_T_base) {
  if (costs.empty() || !is_finite(grid_T_base)) return Contact::kUnknown;
  if (const auto cell = costs.cell_of({grid_T_base.x, grid_T_base.y})) {
    const Cost centre = costs.at(*cell);
    if (centre == kLethalCost && footprint.inscribed_radius_m() > kMinOverlap * costs.resolution_m)
      return Contact::kObstacle;
    // A footprint that leaves the grid is never free, so all of it has to be inside.
    const int reach = static_cast<int>(footprint.circumscribed_radius_m() / costs.resolution_m) + 1;
    const CellBox around = CellBox{*cell, {cell->column + 1, cell->row + 1}}.grown(reach);
    if (around.min.column >= 0 && around.min.row >= 0 && around.max.column <= costs.width &&
        around.max.row <= costs.height && surely_free(costs, footprint, centre))
      return Contact::kFree;
  }
  const ToCells to_cells(costs, grid_T_base);
  Contact worst = Contact::kFree;
  for (const auto& part_m : footprint.convex_parts_m()) {
    cover(costs, part_m, to_cells, worst);
    if (worst == Contact::kObstacle) break;
  }
  return worst;
}

Contact contact_along(const CostGrid& costs, const Footprint& footprint, const Pose2& from, const Pose2& to) {
  if (costs.empty() || !is_finite(from) || !is_finite(to)) return Contact::kUnknown;
  const double yaw = wrap_angle(to.yaw - from.yaw);
  const double motion_m =
      std::hypot(to.x - from.x, to.y - from.y) + std::abs(yaw) * footprint.circumscribed_radius_m();
  const double steps = std::ceil(motion_m / (0.5 * costs.resolution_m));
  for (double i = 0; i <= steps; ++i) {
    const double part = steps > 0 ? i / steps : 0;
    const Pose2 pose{from.x + part * (to.x - from.x), from.y + part * (to.y - from.y), from.yaw + part * yaw};
    if (const Contact here = contact(costs, footprint, pose); here != Contact::kFree) return here;
  }
  return Contact::kFree;
}

}  // namespace extperfc::navigate
