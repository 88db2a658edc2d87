#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/path.hpp"
#include "extperfc/navigate/velocity.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// A rotation by one radian counts as this much translation [m]: lengths along a path are lengths of
/// (x, y, kRadian_m * yaw), so that rotating on the spot is progress too.
inline constexpr double kRadian_m = 0.3;
inline constexpr double kStationStep_m = 0.05;

/// A pose on the path ahead, about the robot's position, with its derivative by the length.
struct Station {
  float x{0};            ///< [m]
  float y{0};            ///< [m]
  float yaw{0};          ///< [rad], continuous along the window, within pi of the robot's at its beginning
  float s{0};            ///< length from the window's beginning [m]
  float dx{0};           ///< by length
  float dy{0};           ///< by length
  float dyaw{0};         ///< by length [rad/m]
  float max_rate{0};     ///< largest length per time [m/s]; filled by the speed profile
  float clearance_m{0};  ///< of the footprint; filled by the speed profile
  int cost{0};           ///< of the cell; filled by the speed profile
};

/// Where the robot is along its path. Only a stretch about the last place is searched, so a path that
/// crosses itself or comes back is driven in its order.
class PathWindow {
 public:
  /// The same goal replanned goes on near the old place or begins anew: whichever is nearer to the robot.
  /// Precondition: not empty. A differential base's headings are made to follow the path.
  void set(const Path& path, BaseKind base);
  [[nodiscard]] bool empty() const { return poses_.empty(); }
  void clear();

  /// Finds the robot. O(poses of the searched stretch).
  void locate(const Pose2& robot);
  [[nodiscard]] const Pose2& goal() const { return poses_.back(); }
  [[nodiscard]] double remaining_m() const { return lengths_.back() - at_m_; }
  [[nodiscard]] double travelled_m() const { return at_m_; }
  /// The nearest pose of the path.
  [[nodiscard]] Pose2 nearest() const { return pose_at(at_m_); }

  /// Stations every kStationStep_m from the robot's place on, for length_m or to the end, about
  /// `robot`'s position. At least 2.
  void stations(const Pose2& robot, double length_m, std::vector<Station>& out) const;

 private:
  struct Match {
    double distance_m{0};
    double at_m{0};
  };
  [[nodiscard]] Pose2 pose_at(double length_m) const;
  [[nodiscard]] Match match(const Pose2& robot, double from_m, double to_m) const;

  std::vector<Pose2> poses_;     ///< yaw continuous
  std::vector<double> lengths_;  ///< of each pose from the first
  double at_m_{0};
  bool fresh_{true};    ///< set() came after the last locate()
  bool driven_{false};  ///< at_m_ holds a place of the path before
};

/// Derivatives by length and lengths of stations whose poses changed.
void differentiate(std::vector<Station>& stations);

}  // namespace extperfc::navigate
