#pragma once

#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/local_planner.hpp"

namespace extperfc::navigate {

/// Who walks towards the robot, and the strips of floor that they come along: where there is room, the robot
/// keeps to the side, so that neither has to stop. Positions are about the robot's.
class OncomingPeople {
 public:
  /// `inscribed_m`: the robot's half width. Who walks slower than 0.25 m/s is not counted.
  void set(const std::vector<MovingObstacle>& people, const Eigen::Vector2d& middle_m, float inscribed_m);
  [[nodiscard]] bool empty() const { return strips_.empty(); }
  /// What is missing, in squares and summed over the strips [m^2], to pass each person comfortably at a point
  /// of a path that leads along `direction` (of length 1). 0 where people walk across
  /// the path or along with it.
  [[nodiscard]] float lack2_m2(const Eigen::Vector2f& point_m, const Eigen::Vector2f& direction) const;

 private:
  struct Strip {
    Eigen::Vector2f from_m;
    Eigen::Vector2f heading;
    float length_m{0};
    float apart_m{0};  ///< between the strip's middle and the robot's
  };
  std::vector<Strip> strips_;
};

}  // namespace extperfc::navigate
