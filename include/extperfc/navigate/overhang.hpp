#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::navigate {

/// What of a robot's links sticks out beyond its footprint, e.g. arms. Immutable, so it may be shared between
/// threads.
class Overhang {
 public:
  /// `base_link` is the frame of the footprint. Links whose collision shapes lie wholly above `max_height_m`
  /// over it do not count. Error: no such link.
  [[nodiscard]] static Result<Overhang> make(const RobotModel& robot, const std::string& base_link,
                                             double max_height_m);

  /// Points [m] of the base's frame that the footprint does not hold: points around the links' collision
  /// shapes, whose convex hull holds those. Joints that are not given are at 0, or at the limit nearest to
  /// it. O(links).
  [[nodiscard]] std::vector<Eigen::Vector2d> points(const std::map<std::string, double>& positions,
                                                    const Footprint& footprint) const;

 private:
  Overhang(RobotModel robot, int base_link, double max_height_m)
      : robot_(std::move(robot)), base_link_(base_link), max_height_m_(max_height_m) {}

  RobotModel robot_;
  int base_link_;
  double max_height_m_;
};

}  // namespace extperfc::navigate
