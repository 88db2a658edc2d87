#include "extperfc/localize/localizer.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "extperfc/world/pose.hpp"

#include "localize/monte_carlo.hpp"
#include "localize/pose_bins.hpp"
#include "localize/wrong.hpp"

namespace extperfc::localize {

namespace {

Result<void> check_map(const std::shared_ptr<const OccupancyGrid>& map) {
  constexpr std::size_t kLongestSide =
      30000;  // cells; the field's columns and rows are exact in single precision
  if (!map || map->empty()) return wrong("the map is empty");
  if (map->width == 0 || map->height == 0 || map->width > kLongestSide || map->height > kLongestSide)
    return wrong("the map has " + std::to_string(map->width) + " x " + std::to_string(map->height) +
                 " cells; each side must have 1 to 30000");
  if (map->cells.size() != map->width * map->height)
    return wrong("the map has " + std::to_string(map->cells.size()) +
                 " cells, not width * height = " + std::to_string(map->width * map->height));
  if (!std::isfinite(map->resolution_m) || map->resolution_m <= 0)
    return wrong("the map's resolution is " + std::to_string(map->resolution_m) + " m, must be above 0");
  if (!is_finite(map->origin)) return wrong("the map's origin is not finite");
  if (FreeSpace(map).cells() == 0) return wrong("map has no free cells: cannot place particles");
  return {};
}

/// A matrix L with L * L^T = covariance, if the covariance is valid.
std::optional<Eigen::Matrix3d> square_root(const Eigen::Matrix3d& covariance) {
  if (!covariance.allFinite()) return std::nullopt;
  const double scale = std::max(covariance.cwiseAbs().maxCoeff(), 1e-12);
  if ((covariance - covariance.transpose()).cwiseAbs().maxCoeff() > 1e-6 * scale) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  if (solver.info() != Eigen::Success || solver.eigenvalues().minCoeff() < -1e-6 * scale) return std::nullopt;
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

}  // namespace

/// Changes frames, and decides when a scan is worth an update.
class Localizer::Impl {
 public:
  Impl(const LocalizerParams& params, std::shared_ptr<const OccupancyGrid> map)
      : params_(params), filter_(params, std::move(map)) {
    describe_particles();
  }

  void set_map(std::shared_ptr<const OccupancyGrid> map) {
    filter_.set_map(std::move(map));
    listed_ = false;
  }

  void initialize_globally() {
    filter_.initialize_globally();
    last_odom_.reset();
    describe_particles();
  }

  void set_pose(const Pose2& mean, const Eigen::Matrix3d& covariance, const Eigen::Matrix3d& root) {
    filter_.initialize_around(compose(inverse(filter_.map().origin), mean),
                              rotation_by(-filter_.map().origin.yaw) * root);
    last_odom_.reset();
    listed_ = false;
    estimate_ = PoseEstimate{{mean.x, mean.y, wrap_angle(mean.yaw)}, covariance, 1, 0, false};
  }

  std::optional<PoseEstimate> update(const LaserScan& scan, const Pose2& odom_T_base, bool force) {
    if (last_odom_) {
      const Pose2 motion = between(*last_odom_, odom_T_base);
      const bool moved = std::hypot(motion.x, motion.y) >= params_.update_min_d ||
                         std::abs(motion.yaw) >= params_.update_min_a;
      if (!moved && !force) return std::nullopt;
      filter_.propagate(motion);
    }
    last_odom_ = odom_T_base;
    estimate_ = in_map(filter_.update(scan));
    listed_ = false;
    return estimate_;
  }

  const PoseEstimate& estimate() const { return estimate_; }

  const std::vector<Particle>& particles() {
    if (listed_) return list_;
    const ParticleSet& particles = filter_.particles();
    list_.resize(particles.size());
    for (std::size_t i = 0; i < particles.size(); ++i)
      list_[i] = {compose(filter_.map().origin, {particles.x[i], particles.y[i], particles.yaw[i]}),
                  particles.weight[i]};
    listed_ = true;
    return list_;
  }

 private:
  static Eigen::Matrix3d rotation_by(double angle_rad) {
    return Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  }

  void describe_particles() {
    estimate_ = in_map(heaviest_cluster(filter_.particles(), PoseBins(filter_.particles())));
    listed_ = false;
  }

  [[nodiscard]] PoseEstimate in_map(PoseEstimate estimate) const {
    const Pose2& origin = filter_.map().origin;
    estimate.pose = compose(origin, estimate.pose);
    const Eigen::Matrix3d rotated = rotation_by(origin.yaw) * estimate.covariance * rotation_by(-origin.yaw);
    estimate.covariance = 0.5 * (rotated + rotated.transpose());  // symmetric to the last digit
    return estimate;
  }

  LocalizerParams params_;
  MonteCarlo filter_;
  std::optional<Pose2> last_odom_;
  PoseEstimate estimate_{{}, Eigen::Matrix3d::Zero(), 0, 0, false};
  std::vector<Particle> list_;  ///< of the filter's particles in the map's frame
  bool listed_{false};
};

Result<Localizer> Localizer::make(const LocalizerParams& params, std::shared_ptr<const OccupancyGrid> map) {
  if (auto checked = validate(params); !checked) return tl::unexpected(checked.error());
  if (auto checked = check_map(map); !checked) return tl::unexpected(checked.error());
  return Localizer(std::make_unique<Impl>(params, std::move(map)));
}

Localizer::Localizer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;
Localizer::~Localizer() = default;

Result<void> Localizer::set_pose(const Pose2& mean, const Eigen::Matrix3d& covariance) {
  if (!is_finite(mean)) return wrong("the initial pose is not finite");
  const auto root = square_root(covariance);
  if (!root)
    return wrong("the covariance of the initial pose must be finite, symmetric and positive semi-definite");
  impl_->set_pose(mean, covariance, *root);
  return {};
}

void Localizer::initialize_globally() {
  impl_->initialize_globally();
}

Result<void> Localizer::set_map(std::shared_ptr<const OccupancyGrid> map) {
  if (auto checked = check_map(map); !checked) return checked;
  impl_->set_map(std::move(map));
  return {};
}

Result<std::optional<PoseEstimate>> Localizer::update(const LaserScan& scan, const Pose2& odom_T_base,
                                                      bool force) {
  if (auto checked = extperfc::validate(scan); !checked) return tl::unexpected(checked.error());
  if (!is_finite(odom_T_base)) return wrong("the odometry's pose is not finite");
  return impl_->update(scan, odom_T_base, force);
}

const PoseEstimate& Localizer::estimate() const {
  return impl_->estimate();
}

const std::vector<Particle>& Localizer::particles() const {
  return impl_->particles();
}

}  // namespace extperfc::localize
