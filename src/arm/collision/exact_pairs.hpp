#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "arm/collision/gjk.hpp"
#include "arm/collision/scene.hpp"

namespace extperfc::arm {

/// A direction in the root frame and how far it separates two shapes along it: every point of the first lies
/// at least `gap_m` further along `normal` than every point of the second. Not positive: not separated.
struct Separation {
  Eigen::Vector3d normal{Eigen::Vector3d::UnitZ()};
  double gap_m{0};
};

/// What counts as free keeps this beyond its padding: above what a distance may be off by, so that no check
/// of a state finds a contact on a motion that was proven [m].
constexpr double kMinGap_m = 1e-6;

/// Where a scene's bodies are, and its moving parts as far as they were asked for. Not thread-safe.
class BodyPlacement {
 public:
  void set(const Scene& scene, const std::vector<Pose>& root_T_body);
  /// For the poses of a robot at its joint positions.
  void set(const Bodies& bodies, const Scene& scene, const double* positions);

  struct Part {
    Pose root_T_part;
    Eigen::Vector3d half;  ///< of its axis-parallel bounding box about its origin
  };
  [[nodiscard]] const std::vector<Pose>& bodies() const { return root_T_body_; }
  [[nodiscard]] const Part& part(int index) const;

 private:
  const Scene* scene_{nullptr};
  std::vector<Pose> root_T_body_;
  mutable std::vector<Part> parts_;
  mutable std::vector<char> known_;
};

/// Bodies at one moment of a motion, in the root frame.
struct Moment {
  BodyPlacement placement;
  std::vector<Eigen::Vector3d> angular_velocity;  ///< angular velocity of each body
  std::vector<Eigen::Vector3d> sliding;  ///< velocity of the point of each body that is at the root's origin
};

/// Sets `angular_velocity` and `sliding` from the poses and each joint's rate.
void set_velocities(const Bodies& bodies, const std::vector<double>& rates, Moment& moment);

/// Single pairs of a scene: distances by GJK with a certificate (gjk.hpp), depths of penetration by Bullet's
/// EPA. Not thread-safe.
class ExactPairs {
 public:
  explicit ExactPairs(const Scene& scene);
  ~ExactPairs();
  ExactPairs(const ExactPairs&) = delete;
  ExactPairs& operator=(const ExactPairs&) = delete;

  /// The separation of a pair, as GJK finds it and the support functions confirm: its gap is a lower bound of
  /// the distance, and within kGjkTolerance_m and 1 % of it. A direction that separates is remembered.
  [[nodiscard]] Separation separation(int pair, const BodyPlacement& placement);
  /// The separation along the remembered direction, rotated with the common ancestor; std::nullopt the first
  /// time.
  [[nodiscard]] std::optional<Separation> remembered(int pair, const BodyPlacement& placement) const;
  /// Distance, to kGjkTolerance_m, or minus the depth of penetration (EPA) [m].
  [[nodiscard]] double signed_distance(int pair, const BodyPlacement& placement);
  /// A lower bound of the distance from bounding boxes; cheap.
  [[nodiscard]] double rough_bound(int pair, const BodyPlacement& placement) const;
  /// Whether the plane of `separation`, found at `moment`, keeps the pair its padding and kMinGap_m apart
  /// for all |t| <= half, when each point strays at most `bend_m` from its motion linear in t, both together.
  [[nodiscard]] bool stays_apart(int pair, const Moment& moment, const Separation& separation, double half,
                                 double bend_m) const;

  [[nodiscard]] std::uint64_t queries() const { return queries_; }

 private:
  struct Bullet;
  [[nodiscard]] Proximity proximity(const PartPair& pair, const BodyPlacement& placement,
                                    double relative_tolerance);
  [[nodiscard]] Separation along(const PartPair& pair, const BodyPlacement& placement,
                                 const Eigen::Vector3d& normal) const;
  /// Smallest value of m . x over the moving part.
  [[nodiscard]] double lowest(int part, const BodyPlacement& placement, const Eigen::Vector3d& m) const;
  /// Largest value of m . x over the pair's second shape.
  [[nodiscard]] double highest(const PartPair& pair, const BodyPlacement& placement,
                               const Eigen::Vector3d& m) const;

  const Scene& scene_;
  std::unique_ptr<Bullet> bullet_;
  std::vector<Eigen::Vector3d> obstacle_half_;  ///< as BodyPlacement::Part::half
  std::vector<Eigen::Vector3d> axes_;  ///< per pair: the last separating direction, in the ancestor's frame
  std::uint64_t queries_{0};
};

}  // namespace extperfc::arm
