#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::localize {

enum class SensorModel { kLikelihoodField, kBeam };  ///< Probabilistic Robotics, tables 6.3 and 6.1
enum class OdometryModel {
  kDifferential,  ///< Probabilistic Robotics, table 5.6
  kOmni,          ///< the same with a fifth noise for sideways motion
};

/// Names and meaning as in amcl, whose configurations fit (amcl's diff-corrected and omni-corrected models).
struct LocalizerParams {
  int min_particles{500};             ///< [1, max_particles]
  int max_particles{5000};            ///< [min_particles, 1000000]
  double kld_err{0.01};               ///< largest error between true and estimated distribution, (0, 1)
  double kld_z{0.99};                 ///< probability that the error is below kld_err, (0.5, 1)
  double update_min_d{0.2};           ///< motion before the next update [m], >= 0
  double update_min_a{0.2};           ///< [rad], >= 0
  int resample_interval{2};           ///< updates from resampling to resampling, >= 1
  double recovery_alpha_slow{0.001};  ///< of the slow average of the fit, [0, 1); 0: no recovery
  double recovery_alpha_fast{0.1};    ///< of the fast one, [0, 1)
  SensorModel sensor_model{SensorModel::kLikelihoodField};
  int laser_max_beams{60};     ///< evenly spaced, [2, 10000]
  double laser_min_range{-1};  ///< [m]; -1: the scan's
  double laser_max_range{-1};  ///< [m]; -1: the scan's
  double laser_z_hit{0.95};    ///< weights of the parts of the model, >= 0; z_hit and z_rand > 0
  double laser_z_short{0.1};
  double laser_z_max{0.05};
  double laser_z_rand{0.05};
  double laser_sigma_hit{0.2};     ///< [m], > 0
  double laser_lambda_short{0.1};  ///< [1/m], > 0
  double laser_likelihood_max_dist{
      2.0};  ///< larger distances from an end point to an obstacle are clipped [m], > 0
  OdometryModel odometry_model{OdometryModel::kDifferential};
  double odom_alpha1{0.2};  ///< rotation noise from rotation, >= 0: variance per squared radian or metre
  double odom_alpha2{0.2};  ///< rotation noise from translation
  double odom_alpha3{0.2};  ///< translation noise from translation
  double odom_alpha4{0.2};  ///< translation noise from rotation
  double odom_alpha5{0.2};  ///< sideways noise, omni only
  std::uint64_t seed{1};
};

/// An error that names the first parameter out of its range.
[[nodiscard]] Result<void> validate(const LocalizerParams& params);

struct Particle {
  Pose2 pose;        ///< of the base in the map
  double weight{0};  ///< all sum to one
};

struct PoseEstimate {
  Pose2 pose;  ///< of the base in the map: mean of the heaviest cluster, moved to where the scan fits best
  Eigen::Matrix3d covariance;  ///< of x, y, yaw over that cluster [m, m, rad]
  double cluster_weight{0};    ///< fraction of the particles' weight in that cluster, (0, 1]
  double fit{0};               ///< fraction of the returns within 0.15 m of an obstacle of the map, [0, 1]
  bool resampled{false};
};

/// Monte Carlo localization in a known map with KLD-sampling (Fox 2003; Probabilistic Robotics, table 8.4)
/// and recovery from wrong poses (augmented MCL, table 8.3, with new particles where the scan fits). One
/// thread at a time. Same input and seed, same result.
class Localizer {
 public:
  /// Starts with global localization. Errors: validate(params), a map that is damaged or has no free cell.
  [[nodiscard]] static Result<Localizer> make(const LocalizerParams& params,
                                              std::shared_ptr<const OccupancyGrid> map);
  Localizer(Localizer&&) noexcept;
  Localizer& operator=(Localizer&&) noexcept;
  ~Localizer();

  /// Particles from a normal distribution around `mean`. Errors: non-finite values, a covariance that is not
  /// symmetric and positive semi-definite.
  [[nodiscard]] Result<void> set_pose(const Pose2& mean, const Eigen::Matrix3d& covariance);
  /// Global localization: particles uniform over the free cells.
  void initialize_globally();
  /// Replaces the map and keeps the particles. Errors: as of make(); the old map then stays.
  [[nodiscard]] Result<void> set_map(std::shared_ptr<const OccupancyGrid> map);

  /// One scan with the odometry's pose of the base at its stamp. No value when the robot has not moved enough
  /// since the last update (unless `force`): the estimate then follows odometry from the last one.
  /// Errors: validate(scan), non-finite odometry.
  [[nodiscard]] Result<std::optional<PoseEstimate>> update(const LaserScan& scan, const Pose2& odom_T_base,
                                                           bool force = false);

  [[nodiscard]] const PoseEstimate& estimate() const;  ///< of the last update
  [[nodiscard]] const std::vector<Particle>& particles() const;

 private:
  class Impl;
  explicit Localizer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace extperfc::localize
