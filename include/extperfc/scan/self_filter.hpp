#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::scan {

/// All points within `radius_m` of the line from `from` to `to`: a pill. With from == to it is a sphere.
struct Capsule {
  Eigen::Vector3d from{0, 0, 0};  ///< in the frame of its volume [m]
  Eigen::Vector3d to{0, 0, 0};    ///< [m]
  double radius_m{0};
};

struct Cuboid {
  Pose frame_T_box{Pose::Identity()};  ///< pose of its middle
  Eigen::Vector3d size{0, 0, 0};       ///< whole edges [m]
};

/// A part of the robot that moves with a tf frame: a capsule or a box.
struct SelfVolume {
  std::string frame;
  std::optional<Capsule> capsule;
  std::optional<Cuboid> box;
};

/// Separates the robot's own points from those of its surroundings. Points are tested in the sensor's frame:
/// the robot moves with its sensor, so its points must not be deskewed by the motion over the floor.
///
/// place() is O(volumes), contains() O(volumes) with a quick test by distance first.
class SelfFilter {
 public:
  SelfFilter() = default;  ///< the robot has no volumes: contains() is always false

  /// `padding_m` is added to every side: for calibration and for the motion of arms during a sweep.
  /// Errors name the volume: no frame, neither or both shapes, sizes out of (0, 5] m, more than 256 volumes.
  [[nodiscard]] static Result<SelfFilter> make(const std::vector<SelfVolume>& volumes, double padding_m);

  /// The frames that place() wants poses of, each once.
  [[nodiscard]] const std::vector<std::string>& frames() const { return frames_; }

  /// `sensor_T_frame[i]` belongs to frames()[i]; without a pose the frame's volumes do not count.
  void place(const std::vector<std::optional<Pose>>& sensor_T_frame);

  /// A point in the sensor's frame [m].
  [[nodiscard]] bool contains(const Eigen::Vector3f& point) const;

 private:
  struct Part {
    std::size_t frame{0};
    Pose frame_T_part{Pose::Identity()};  ///< a capsule lies along z about its middle
    Eigen::Vector3f half{0, 0, 0};        ///< of a box; of a capsule: 0, 0, half of its line
    float radius{0};                      ///< of a capsule; of a box 0
  };
  struct Placed {
    Eigen::Vector3f middle{0, 0, 0};
    float reach_squared{0};  ///< of a bounding sphere
    Eigen::Matrix3f part_R_sensor{Eigen::Matrix3f::Identity()};
    Eigen::Vector3f half{0, 0, 0};
    float radius_squared{0};
  };

  std::vector<std::string> frames_;
  std::vector<Part> parts_;
  std::vector<Placed> placed_;
  float reach_squared_{0};  ///< from the sensor to the farthest point of the robot
};

}  // namespace extperfc::scan
