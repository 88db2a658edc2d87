#include "test/benchmark/localize/subject.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include <Eigen/Eigenvalues>

#include "test/benchmark/localize/peer.hpp"

namespace extperfc::benchmark {
namespace {

using localize::Localizer;
using localize::LocalizerParams;

constexpr double kSigma_m = 0.3;
constexpr double kSigma_rad = 0.2;

class Ours : public Subject {
 public:
  Ours(const std::shared_ptr<const OccupancyGrid>& map, const LocalizerParams& params)
      : localizer_(make(map, params)) {}
  void begin_at(const Pose2& pose) override {
    const Eigen::Vector3d variances(kSigma_m * kSigma_m, kSigma_m * kSigma_m, kSigma_rad * kSigma_rad);
    if (!localizer_.set_pose(pose, variances.asDiagonal())) std::abort();
  }
  void initialize_globally() override { localizer_.initialize_globally(); }
  void update(const LaserScan& scan, const Pose2& odom) override {
    if (!localizer_.update(scan, odom, true)) std::abort();
  }
  [[nodiscard]] Pose2 pose() const override { return localizer_.estimate().pose; }
  [[nodiscard]] std::optional<double> sigma_m() const override {
    const Eigen::Matrix2d position = localizer_.estimate().covariance.topLeftCorner<2, 2>();
    return std::sqrt(
        std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(position).eigenvalues().maxCoeff()));
  }

 private:
  static Localizer make(const std::shared_ptr<const OccupancyGrid>& map, const LocalizerParams& params) {
    auto made = Localizer::make(params, map);
    if (!made) std::abort();
    return std::move(*made);
  }
  Localizer localizer_;
};

class Theirs : public Subject {
 public:
  explicit Theirs(std::unique_ptr<Peer> peer) : peer_(std::move(peer)) {}
  void begin_at(const Pose2& pose) override {
    peer_->begin_at(pose, kSigma_m, kSigma_rad);
    last_.reset();
  }
  void initialize_globally() override {
    peer_->initialize_globally();
    last_.reset();
  }
  void update(const LaserScan& scan, const Pose2& odom) override {
    peer_->update(scan, last_ ? between(*last_, odom) : Pose2{});
    last_ = odom;
  }
  [[nodiscard]] Pose2 pose() const override { return peer_->pose(); }
  [[nodiscard]] std::optional<double> sigma_m() const override { return std::nullopt; }

 private:
  std::unique_ptr<Peer> peer_;
  std::optional<Pose2> last_;
};

}  // namespace

std::unique_ptr<Subject> make_ours(const std::shared_ptr<const OccupancyGrid>& map,
                                   const LocalizerParams& params) {
  return std::make_unique<Ours>(map, params);
}

std::unique_ptr<Subject> make_theirs(const OccupancyGrid& map, int min_particles, int max_particles,
                                     std::size_t rays) {
  constexpr std::size_t kBeams = 60;
  auto peer = Peer::make(map, min_particles, max_particles, std::max<std::size_t>(1, rays / kBeams));
  if (!peer) return nullptr;
  return std::make_unique<Theirs>(std::move(peer));
}

bool moved(const Pose2& last, const Pose2& now) {
  constexpr double kUpdate_m = 0.2;
  constexpr double kUpdate_rad = 0.2;
  const Pose2 motion = between(last, now);
  return std::hypot(motion.x, motion.y) >= kUpdate_m || std::abs(motion.yaw) >= kUpdate_rad;
}

double apart_deg(const Pose2& a, const Pose2& b) {
  return std::abs(wrap_angle(a.yaw - b.yaw)) * 180 / M_PI;
}

bool is_right(const Pose2& pose, const Pose2& truth) {
  constexpr double kRight_m = 0.5;
  constexpr double kRight_deg = 12;
  return distance_m(pose, truth) < kRight_m && apart_deg(pose, truth) < kRight_deg;
}

}  // namespace extperfc::benchmark
