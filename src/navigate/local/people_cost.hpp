#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/local_planner.hpp"

namespace extperfc::navigate {

/// Costs of being near people at a time: each goes on with its velocity, less and less surely. Who comes
/// straight to the robot is expected to stop before it: a robot that expected to be run into would give
/// ground to who follows only because it does.
class PeopleCost {
 public:
  /// Precomputes where everybody is after each step, about `middle_m`. `body_m` is the robot's radius: the
  /// mean of the inscribed and the circumscribed one.
  void set(const std::vector<MovingObstacle>& people, const Eigen::Vector2d& middle_m, float body_m,
           float inscribed_m, int steps, float step_s);
  [[nodiscard]] bool empty() const { return persons_ == 0; }
  /// 0: far from all people, 1: at arm's length, more in front of a person who walks; kTouches and more:
  /// touches.
  [[nodiscard]] float at(std::size_t step, float x_m, float y_m) const;

  static constexpr float kTouches = 20;

 private:
  struct Place {
    float x{0};
    float y{0};
    float heading_x{0};
    float heading_y{0};
    float touch2_m2{0};       ///< squared distance of touching
    float body_m{0};          ///< both radii
    float inverse_side_m{1};  ///< of how far discomfort reaches
    float inverse_front_m{1};
    float far2_m2{0};  ///< squared distance beyond which the cost is 0
  };
  std::size_t persons_{0};
  std::vector<Place> places_;  ///< step by step
};

}  // namespace extperfc::navigate
