#pragma once

#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// The robot's outline on the floor: a simple polygon in the base's frame that holds the base's origin.
class Footprint {
 public:
  /// Corners in either order [m]; repeated ones count once. Errors: fewer than 3 or more than 100 corners,
  /// not finite, edges that cross or touch, an area below 1e-4 m^2, the origin outside, a corner more than 10
  /// m from it.
  [[nodiscard]] static Result<Footprint> make(std::vector<Eigen::Vector2d> corners_m);
  /// A regular polygon with 16 corners around a circle. Throws std::invalid_argument unless 0.01 <= radius_m
  /// <= 9.8.
  [[nodiscard]] static Footprint circle(double radius_m);

  /// Counter-clockwise [m].
  [[nodiscard]] const std::vector<Eigen::Vector2d>& corners_m() const { return corners_m_; }
  [[nodiscard]] double inscribed_radius_m() const {
    return inscribed_radius_m_;
  }  ///< about the base's origin
  [[nodiscard]] double circumscribed_radius_m() const { return circumscribed_radius_m_; }  ///< the same
  /// Every edge moved outwards by margin_m (corners mitred, cut off at twice the margin); negative: inwards
  /// as far as it stays valid. Where a dent closes by that, the convex hull is padded. Precondition: finite.
  [[nodiscard]] Footprint padded(double margin_m) const;
  /// The convex hull of this footprint and further points of the base's frame [m]: arms that stick out.
  /// Points that are not finite do not count.
  [[nodiscard]] Footprint extended(const std::vector<Eigen::Vector2d>& points_m) const;
  /// Convex polygons that make up the footprint, counter-clockwise [m].
  [[nodiscard]] const std::vector<std::vector<Eigen::Vector2d>>& convex_parts_m() const { return parts_m_; }

 private:
  explicit Footprint(std::vector<Eigen::Vector2d> corners_m);

  std::vector<Eigen::Vector2d> corners_m_;
  std::vector<std::vector<Eigen::Vector2d>> parts_m_;
  double inscribed_radius_m_{0};
  double circumscribed_radius_m_{0};
};

/// What a footprint covers. Ordered: the worst counts.
enum class Contact {
  kFree,
  kUnknown,   ///< touches a cell of kUnknownCost, or leaves the grid
  kObstacle,  ///< touches a cell of kLethalCost
};

/// Exact: a cell counts when its square and the polygon, its inside included, overlap by more than 1e-6 of a
/// cell; touching sides are no contact. The centre's cost decides at once where it can: lethal, or below the
/// cost that CostGrid::inflation gives at the circumscribed radius. O(cells under the footprint) else. A pose
/// that is not finite leaves the grid. Any number of threads may ask.
[[nodiscard]] Contact contact(const CostGrid& costs, const Footprint& footprint, const Pose2& grid_T_base);

/// The same for a straight motion, turning evenly: checked at steps of at most half a cell of any corner's
/// motion. The first pose that touches decides.
[[nodiscard]] Contact contact_along(const CostGrid& costs, const Footprint& footprint, const Pose2& from,
                                    const Pose2& to);

}  // namespace extperfc::navigate
