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
  /// Corners in either order [m]. Errors: fewer than 3 or more than 100 corners, not finite, edges that
  /// cross, an area below 1e-4 m^2, the origin outside, larger than 10 m.
  [[nodiscard]] static Result<Footprint> make(std::vector<Eigen::Vector2d> corners_m);
  /// A regular polygon with 16 corners around a circle. Precondition: 0 < radius_m <= 10.
  [[nodiscard]] static Footprint circle(double radius_m);

  /// Counter-clockwise [m].
  [[nodiscard]] const std::vector<Eigen::Vector2d>& corners_m() const { return corners_m_; }
  [[nodiscard]] double inscribed_radius_m() const {
    return inscribed_radius_m_;
  }  ///< about the base's origin
  [[nodiscard]] double circumscribed_radius_m() const { return circumscribed_radius_m_; }  ///< the same
  /// Every edge moved outwards by margin_m (corners mitred, at most by twice the margin); negative: inwards
  /// as far as it stays valid.
  [[nodiscard]] Footprint padded(double margin_m) const;
  /// The convex hull of this footprint and further points of the base's frame [m]: arms that stick out.
  [[nodiscard]] Footprint extended(const std::vector<Eigen::Vector2d>& points_m) const;

 private:
  explicit Footprint(std::vector<Eigen::Vector2d> corners_m);

  std::vector<Eigen::Vector2d> corners_m_;
  double inscribed_radius_m_{0};
  double circumscribed_radius_m_{0};
};

/// What a footprint covers. Ordered: the worst counts.
enum class Contact {
  kFree,
  kUnknown,   ///< touches a cell of kUnknownCost, or leaves the grid
  kObstacle,  ///< touches a cell of kLethalCost
};

/// Exact: a cell counts when its square and the polygon overlap, the polygon's inside included. The centre's
/// cost decides at once where it can (below the cost of the circumscribed radius: free). O(cells under the
/// footprint) else. Any number of threads may ask.
[[nodiscard]] Contact contact(const CostGrid& costs, const Footprint& footprint, const Pose2& grid_T_base);

/// The same for a straight motion, turning evenly: checked at steps of at most half a cell of any corner's
/// motion. The first pose that touches decides.
[[nodiscard]] Contact contact_along(const CostGrid& costs, const Footprint& footprint, const Pose2& from,
                                    const Pose2& to);

}  // namespace extperfc::navigate
