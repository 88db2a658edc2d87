#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/rng.hpp"
#include "extperfc/simulate/world_spec.hpp"

#include "simulate/worlds/object_model.hpp"

namespace extperfc::simulate {

/// A world that grows object by object, and who stands where.
class RandomScene {
 public:
  RandomScene(std::string name, std::uint64_t seed);

  [[nodiscard]] Rng& rng() { return rng_; }
  [[nodiscard]] WorldSpec& world() { return world_; }

  /// Puts an object; its name is `kind` and a running number.
  void put(const ObjectModel& model, const std::string& kind, const Pose& world_T_object);
  /// Puts an object where its rectangle of `size_m` (along its own axes) keeps `gap_m` to all that were put
  /// so before, and says so; false when there is no room.
  bool put_apart(const ObjectModel& model, const std::string& kind, const Pose& world_T_object,
                 const Eigen::Vector2d& size_m, double gap_m);
  /// Keeps a rectangle free of later put_apart().
  void reserve(const Eigen::Vector2d& min_m, const Eigen::Vector2d& max_m);
  /// Whether a rectangle shares area with one that is kept free.
  [[nodiscard]] bool reserved(const Pose& world_T_rectangle, const Eigen::Vector2d& size_m) const;

 private:
  Rng rng_;
  WorldSpec world_;
  std::vector<std::vector<Eigen::Vector2d>> taken_;     ///< convex polygons of what was put
  std::vector<std::vector<Eigen::Vector2d>> reserved_;  ///< of what is kept free
};

/// Largest distance of an object's shadow from its origin [m].
[[nodiscard]] double reach_m(const ObjectModel& model);

/// Furniture, paintings and windows along the walls of a rectangular room. `height_m` of the walls.
void furnish_walls(RandomScene& scene, const Eigen::Vector2d& min_m, const Eigen::Vector2d& max_m, int count,
                   double height_m);

/// Loose objects on a surface at `world_T_surface` (middle of the rectangle, z up).
struct TableTop {
  Pose world_T_surface{Pose::Identity()};
  Eigen::Vector2d half_m{0.3, 0.5};
};

}  // namespace extperfc::simulate
