#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/local_planner.hpp"

namespace extperfc::navigate {

/// Points on a footprint's outline, and its circles, for quick questions.
struct Outline {
  std::vector<Eigen::Vector2f> points;  ///< in the base's frame [m], at most kSpacing_m apart
  float inscribed_m{0};
  float circumscribed_m{0};

  static constexpr double kSpacing_m = 0.08;
  explicit Outline(const Footprint& footprint);
  Outline() = default;
};

/// Distances to obstacles and unknown cells in a square about the robot, up to kReach_m; positions are about
/// its middle. Keeps its memory from cycle to cycle.
class ClearanceField {
 public:
  static constexpr double kReach_m = 1.2;
  /// Distances below this are to be checked in the grid itself: the field is exact within a cell.
  static constexpr float kCheckBelow_m = 0.13F;

  /// Obstacles under people who move are left out: they will be elsewhere. People who stand are added.
  /// O(cells of the square * cells of the reach), a few operations for 8 cells at once.
  void build(const CostGrid& costs, const Eigen::Vector2d& middle_m, double half_side_m,
             const std::vector<MovingObstacle>& people);

  /// From a point to the nearest obstacle's cell [m], within a cell; at most kReach_m, also outside the
  /// square.
  [[nodiscard]] float distance(float x_m, float y_m) const {
    const int column = static_cast<int>((x_m - left_m_) * cells_per_m_);
    const int row = static_cast<int>((y_m - bottom_m_) * cells_per_m_);
    if (x_m < left_m_ || y_m < bottom_m_ || column >= width_ || row >= height_) return kFar_m;
    return distances_m_[index(column, row)];
  }
  /// The cost of a point's cell; 0 outside.
  [[nodiscard]] Cost cost(float x_m, float y_m) const {
    const int column = static_cast<int>((x_m - left_m_) * cells_per_m_);
    const int row = static_cast<int>((y_m - bottom_m_) * cells_per_m_);
    if (x_m < left_m_ || y_m < bottom_m_ || column >= width_ || row >= height_) return kFreeCost;
    return window_.cells[index(column, row)];
  }
  /// From a footprint's outline to the nearest obstacle [m], within a cell; at most about `enough_m`, below
  /// 0 where the inscribed circle touches.
  [[nodiscard]] float clearance(const Outline& outline, float x_m, float y_m, float cos_yaw, float sin_yaw,
                                float enough_m) const;

  /// The cost map about the robot, without obstacles under people who move, with people who stand.
  [[nodiscard]] const CostGrid& window() const { return window_; }

 private:
  static constexpr float kFar_m = static_cast<float>(kReach_m);
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(column);
  }
  void copy_costs(const CostGrid& costs, const Eigen::Vector2d& middle_m, double half_side_m);
  void mark_obstacles(const std::vector<MovingObstacle>& people, const Eigen::Vector2d& middle_m);
  void mark_disc(const Eigen::Vector2d& at_m, double radius_m, bool obstacle);
  void along_rows();
  void across_rows();

  int width_{0};
  int height_{0};
  int reach_{0};  ///< cells
  float left_m_{0};
  float bottom_m_{0};
  float cells_per_m_{1};
  CostGrid window_;                    ///< the square of the cost map, with the people's changes
  std::vector<std::int16_t> along_;    ///< cells to the nearest obstacle of the row
  std::vector<std::int16_t> squares_;  ///< cells^2 to the nearest obstacle
  std::vector<float> distances_m_;
};

}  // namespace extperfc::navigate
