#pragma once

#include <deque>
#include <vector>

#include "extperfc/simulate/world_spec.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::simulate {

/// A person who walks along a path at constant speed, stands at points of it for some time, and faces
/// forward. Where the robot stands in the path the person waits, and walks back the same path when the robot
/// is still there after 3 s; a step in between takes off as much as it lasts.
class Pedestrian {
 public:
  explicit Pedestrian(const PersonSpec& person);

  /// One step. A person waits while the robot's centre is nearer than 1 m and ahead.
  void step(double step_s, const Pose2& robot);
  [[nodiscard]] const Pose2& pose() const { return pose_; }

 private:
  [[nodiscard]] bool stands(double step_s);
  [[nodiscard]] bool path_is_clear(const Pose2& robot) const;
  void rotate_towards(double heading, double step_s);
  [[nodiscard]] Pose2 at(double along_m) const;
  [[nodiscard]] Pose2 heading_along() const;

  std::vector<Eigen::Vector2d> corners_;  // of the path, there and back when it is open
  double length_m_{0};
  double speed_m_s_;
  double along_m_{0};
  struct Stand {
    double along_m;
    double seconds;
  };
  std::deque<Stand> stands_;  // that are still to come
  double direction_{1};       // -1: backwards along the path
  double waited_s_{0};
  Pose2 pose_;
};

}  // namespace extperfc::simulate
