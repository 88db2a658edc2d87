#include "extperfc/navigate/cost_map.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "extperfc/base/demand.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kMaxShift = 1e8;  // [cells]

std::size_t area(const CellBox& box) {
  if (box.empty()) return 0;
  return static_cast<std::size_t>(box.max.column - box.min.column) *
         static_cast<std::size_t>(box.max.row - box.min.row);
}

}  // namespace

CostMap::CostMap(const CostGrid& grid) : default_cost_(kFreeCost) {
  resize(grid);
}

void CostMap::add(std::shared_ptr<CostLayer> layer) {
  demand(layer != nullptr, "a cost layer must not be null");
  layer->match(grid_);
  layers_.push_back(std::move(layer));
  stale_ = grid_.box();
}

void CostMap::resize(const CostGrid& grid) {
  demand(!grid.empty() && area(grid.box()) == grid.cells.size(), "a cost map must have cells");
  grid_ = grid;
  default_cost_ = grid.cells.front();
  match();
}

void CostMap::match() {
  std::fill(grid_.cells.begin(), grid_.cells.end(), default_cost_);
  unknown_cells_ = default_cost_ == kUnknownCost ? grid_.cells.size() : 0;
  grid_.may_hold_unknown = unknown_cells_ > 0;
  grid_.inflation = {};
  for (const auto& layer : layers_) layer->match(grid_);
  stale_ = grid_.box();
}

void CostMap::centre_on(const Eigen::Vector2d& centre_m) {
  const Eigen::Vector2d half(grid_.width / 2.0, grid_.height / 2.0);
  const Eigen::Vector2d shift = ((centre_m - grid_.origin_m) / grid_.resolution_m - half).array().round();
  if (!shift.allFinite() || shift.cwiseAbs().maxCoeff() > kMaxShift || shift.isZero(0)) return;
  grid_.origin_m += grid_.resolution_m * shift;
  match();
}

std::size_t CostMap::count_unknown(const CellBox& box) const {
  std::size_t count = 0;
  for (int row = box.min.row; row < box.max.row; ++row) {
    const Cost* cells = &grid_.cells[grid_.index({box.min.column, row})];
    count +=
        static_cast<std::size_t>(std::count(cells, cells + (box.max.column - box.min.column), kUnknownCost));
  }
  return count;
}

CellBox CostMap::update(double now_s) {
  CellBox box = std::exchange(stale_, CellBox{});
  for (const auto& layer : layers_)
    box = box.grown(layer->reach_cells(grid_)).joined(layer->take_changes(grid_, now_s));
  box = box.clipped(grid_.box());
  if (box.empty()) return {};
  unknown_cells_ -= count_unknown(box);
  for (int row = box.min.row; row < box.max.row; ++row)
    std::fill_n(&grid_.cells[grid_.index({box.min.column, row})], box.max.column - box.min.column,
                default_cost_);
  for (const auto& layer : layers_) {
    grid_.inflation = {};  // what an earlier layer said need not hold for the lethal cells of this one
    layer->write(grid_, box);
  }
  unknown_cells_ += count_unknown(box);
  grid_.may_hold_unknown = unknown_cells_ > 0;
  cells_written_ += area(box);
  return box;
}

void CostMap::clear() {
  for (const auto& layer : layers_) layer->clear();
}

}  // namespace extperfc::navigate
