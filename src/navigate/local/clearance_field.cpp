#include "navigate/local/clearance_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace extperfc::navigate {

namespace {

constexpr double kMoves_m_s = 0.25;       // slower people stand
constexpr double kPersonMargin_m = 0.12;  // about a person who moves: lethal cells inside are that person
constexpr int kMaxReach = 100;            // cells: squares fit 16 bits

}  // namespace

Outline::Outline(const Footprint& footprint)
    : inscribed_m(static_cast<float>(footprint.inscribed_radius_m())),
      circumscribed_m(static_cast<float>(footprint.circumscribed_radius_m())) {
  const auto& corners_m = footprint.corners_m();
  for (std::size_t i = 0; i < corners_m.size(); ++i) {
    const Eigen::Vector2d edge = corners_m[(i + 1) % corners_m.size()] - corners_m[i];
    const int parts = std::max(1, static_cast<int>(std::ceil(edge.norm() / kSpacing_m)));
    for (int k = 0; k < parts; ++k)
      points.emplace_back((corners_m[i] + edge * (static_cast<double>(k) / parts)).cast<float>());
  }
}

void ClearanceField::build(const CostGrid& costs, const Eigen::Vector2d& middle_m, double half_side_m,
                           const std::vector<MovingObstacle>& people) {
  copy_costs(costs, middle_m, half_side_m);
  reach_ = std::min(kMaxReach, static_cast<int>(std::ceil(kReach_m / costs.resolution_m)));
  mark_obstacles(people, middle_m);
  along_rows();
  across_rows();
}

void ClearanceField::copy_costs(const CostGrid& costs, const Eigen::Vector2d& middle_m, double half_side_m) {
  const Eigen::Vector2d half(half_side_m, half_side_m);
  const Cell low = costs.cell_around(middle_m - half);
  const Cell high = costs.cell_around(middle_m + half);
  const CellBox box = CellBox{low, {high.column + 1, high.row + 1}}.clipped(costs.box());
  width_ = box.empty() ? 0 : box.max.column - box.min.column;
  height_ = box.empty() ? 0 : box.max.row - box.min.row;
  const Eigen::Vector2d corner_m =
      costs.origin_m + costs.resolution_m * Eigen::Vector2d(box.min.column, box.min.row) - middle_m;
  left_m_ = static_cast<float>(corner_m.x());
  bottom_m_ = static_cast<float>(corner_m.y());
  cells_per_m_ = static_cast<float>(1 / costs.resolution_m);
  window_.width = width_;
  window_.height = height_;
  window_.resolution_m = costs.resolution_m;
  window_.origin_m = corner_m + middle_m;
  window_.inflation = costs.inflation;
  window_.may_hold_unknown = costs.may_hold_unknown;
  window_.cells.resize(index(0, height_));
  for (int row = 0; row < height_; ++row) {
    const auto from =
        costs.cells.begin() + static_cast<std::ptrdiff_t>(costs.index({box.min.column, box.min.row + row}));
    std::copy(from, from + width_, window_.cells.begin() + row * width_);
  }
}

void ClearanceField::mark_obstacles(const std::vector<MovingObstacle>& people,
                                    const Eigen::Vector2d& middle_m) {
  along_.resize(window_.cells.size());
  const auto far = static_cast<std::int16_t>(reach_);
  for (std::size_t i = 0; i < window_.cells.size(); ++i)
    along_[i] = window_.cells[i] >= kLethalCost ? std::int16_t{0} : far;
  for (const MovingObstacle& person : people) {
    const bool moves = person.velocity_m_s.norm() > kMoves_m_s;
    if (!moves) window_.inflation = {};  // no costs spread from them
    mark_disc(person.position_m - middle_m, person.radius_m + (moves ? kPersonMargin_m : 0), !moves);
  }
}

void ClearanceField::mark_disc(const Eigen::Vector2d& at_m, double radius_m, bool obstacle) {
  const auto value = static_cast<std::int16_t>(obstacle ? 0 : reach_);
  const float radius = static_cast<float>(radius_m) * cells_per_m_;
  const float column = (static_cast<float>(at_m.x()) - left_m_) * cells_per_m_ - 0.5F;
  const float row = (static_cast<float>(at_m.y()) - bottom_m_) * cells_per_m_ - 0.5F;
  if (!(std::abs(column) < 1e6F && std::abs(row) < 1e6F)) return;
  const int first = std::max(0, static_cast<int>(std::ceil(row - radius)));
  const int last = std::min(height_ - 1, static_cast<int>(std::floor(row + radius)));
  for (int r = first; r <= last; ++r) {
    const float dr = static_cast<float>(r) - row;
    const float half = std::sqrt(std::max(0.0F, radius * radius - dr * dr));
    const int left = std::max(0, static_cast<int>(std::ceil(column - half)));
    const int right = std::min(width_ - 1, static_cast<int>(std::floor(column + half)));
    for (int c = left; c <= right; ++c) {
      const auto i = index(c, r);
      along_[i] = value;
      if (obstacle || window_.cells[i] >= kLethalCost) window_.cells[i] = obstacle ? kLethalCost : kFreeCost;
    }
  }
}

void ClearanceField::along_rows() {
  for (int row = 0; row < height_; ++row) {
    std::int16_t* cells = along_.data() + static_cast<std::ptrdiff_t>(row) * width_;
    for (int c = 1; c < width_; ++c)
      cells[c] = std::min(cells[c], static_cast<std::int16_t>(cells[c - 1] + 1));
    for (int c = width_ - 2; c >= 0; --c)
      cells[c] = std::min(cells[c], static_cast<std::int16_t>(cells[c + 1] + 1));
  }
}

void ClearanceField::across_rows() {
  const int far = reach_ * reach_;
  squares_.assign(window_.cells.size(), static_cast<std::int16_t>(far));
  for (int row = 0; row < height_; ++row) {
    std::int16_t* out = squares_.data() + static_cast<std::ptrdiff_t>(row) * width_;
    const int last = std::min(height_ - 1, row + reach_);
    for (int other = std::max(0, row - reach_); other <= last; ++other) {
      const std::int16_t* in = along_.data() + static_cast<std::ptrdiff_t>(other) * width_;
      const auto offset2 = static_cast<std::int16_t>((other - row) * (other - row));
      for (int c = 0; c < width_; ++c) {
        const auto value = static_cast<std::int16_t>(in[c] * in[c] + offset2);
        out[c] = std::min(out[c], value);
      }
    }
  }
  std::vector<float>& table = distances_m_;
  table.resize(squares_.size());
  const float cell_m = 1 / cells_per_m_;
  for (std::size_t i = 0; i < squares_.size(); ++i)  // to the nearest side of the obstacle's cell
    table[i] = squares_[i] >= far
                   ? kFar_m
                   : cell_m * std::max(0.0F, std::sqrt(static_cast<float>(squares_[i])) - 0.5F);
}

float ClearanceField::clearance(const Outline& outline, float x_m, float y_m, float cos_yaw, float sin_yaw,
                                float enough_m) const {
  const float middle_m = distance(x_m, y_m);
  if (middle_m >= outline.circumscribed_m + enough_m) return enough_m;
  if (middle_m < outline.inscribed_m - 1.5F / cells_per_m_) return middle_m - outline.inscribed_m;
  float nearest_m = enough_m;
  for (const Eigen::Vector2f& point : outline.points)
    nearest_m = std::min(nearest_m, distance(x_m + cos_yaw * point.x() - sin_yaw * point.y(),
                                             y_m + sin_yaw * point.x() + cos_yaw * point.y()));
  return nearest_m;
}

}  // namespace extperfc::navigate
