#include "extperfc/simulate/floor_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulate/worlds/solid.hpp"

namespace extperfc::simulate {

namespace {

constexpr double kTouch = 1e-9;  // a wall that only touches a cell's border does not occupy it [m]
constexpr double kMaxCells = 1e8;

struct Cell {
  int column;
  int row;
};

std::size_t index_of(const FloorPlan& plan, Cell cell) {
  return static_cast<std::size_t>(cell.row) * static_cast<std::size_t>(plan.width) +
         static_cast<std::size_t>(cell.column);
}

bool inside(const FloorPlan& plan, Cell cell) {
  return cell.column >= 0 && cell.row >= 0 && cell.column < plan.width && cell.row < plan.height;
}

Cell cell_of(const FloorPlan& plan, const Eigen::Vector2d& point) {
  const Eigen::Vector2d cells = (point - plan.origin_m) / plan.resolution_m;
  return {static_cast<int>(std::floor(cells.x())), static_cast<int>(std::floor(cells.y()))};
}

Polygon square(const FloorPlan& plan, Cell cell) {
  const double size = plan.resolution_m;
  const Eigen::Vector2d low = plan.origin_m + size * Eigen::Vector2d(cell.column, cell.row);
  return {low, low + Eigen::Vector2d(size, 0), low + Eigen::Vector2d(size, size),
          low + Eigen::Vector2d(0, size)};
}

void fill(FloorPlan& plan, const Polygon& polygon) {
  Eigen::Vector2d low = polygon.front();
  Eigen::Vector2d high = polygon.front();
  for (const auto& point : polygon) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  const Cell from = cell_of(plan, low);
  const Cell to = cell_of(plan, high);
  for (int row = std::max(0, from.row); row <= std::min(to.row, plan.height - 1); ++row)
    for (int column = std::max(0, from.column); column <= std::min(to.column, plan.width - 1); ++column)
      if (overlap(polygon, square(plan, {column, row}), kTouch))
        plan.data[index_of(plan, {column, row})] = kOccupiedCell;
}

void fill_bodies(FloorPlan& plan, const WorldSpec& world, Mobility mobility, double z_min, double z_max) {
  for (const BodySpec& body : world.bodies) {
    if (body.mobility != mobility) continue;
    for (const Shape& shape : body.shapes)
      if (const auto polygon = outline(shape.geometry, body.world_T_body * shape.body_T_shape, z_min, z_max))
        fill(plan, *polygon);
  }
}

/// Marks as free what is unknown and connected to the start by edges of cells.
void flood(FloorPlan& plan, Cell start) {
  std::vector<Cell> open;
  const auto enter = [&](Cell cell) {
    if (!inside(plan, cell) || plan.data[index_of(plan, cell)] != kUnknownCell) return;
    plan.data[index_of(plan, cell)] = kFreeCell;
    open.push_back(cell);
  };
  enter(start);
  while (!open.empty()) {
    const Cell cell = open.back();
    open.pop_back();
    enter({cell.column + 1, cell.row});
    enter({cell.column - 1, cell.row});
    enter({cell.column, cell.row + 1});
    enter({cell.column, cell.row - 1});
  }
}

}  // namespace

Result<FloorPlan> floor_plan(const WorldSpec& world, double resolution_m, double z_min_m, double z_max_m) {
  if (!(resolution_m >= 0.005 && resolution_m <= 1))
    return fail(ErrorCode::kInvalidArgument,
                "floor plan: the resolution must be in [0.005, 1] m, not " + std::to_string(resolution_m));
  if (!(z_min_m < z_max_m))
    return fail(ErrorCode::kInvalidArgument, "floor plan: z_min must be below z_max: exchange them");
  const Eigen::Vector2d cells = (world.max_m - world.min_m) / resolution_m;
  if (!(cells.minCoeff() > 0 && cells.prod() <= kMaxCells))
    return fail(ErrorCode::kInvalidArgument,
                "floor plan: the world \"" + world.name +
                    "\" has no area or more than 10^8 cells: use a coarser grid");
  FloorPlan plan;
  plan.width = static_cast<int>(std::ceil(cells.x() - 1e-6));
  plan.height = static_cast<int>(std::ceil(cells.y() - 1e-6));
  plan.resolution_m = resolution_m;
  plan.origin_m = world.min_m;
  plan.data.assign(static_cast<std::size_t>(plan.width) * static_cast<std::size_t>(plan.height),
                   kUnknownCell);
  fill_bodies(plan, world, Mobility::kFixed, z_min_m, z_max_m);
  flood(plan, cell_of(plan, {world.robot_start.x, world.robot_start.y}));
  fill_bodies(plan, world, Mobility::kMovable, z_min_m, z_max_m);
  return plan;
}

}  // namespace extperfc::simulate
