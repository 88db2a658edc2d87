#include <algorithm>
#include <cmath>

#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/random/RandomGenerators.h>
#include <mrpt/slam/CMonteCarloLocalization2D.h>

#include "test/benchmark/localize/peer.hpp"

namespace extperfc::benchmark {
namespace {

using mrpt::bayes::CParticleFilter;
using mrpt::maps::COccupancyGridMap2D;
using mrpt::obs::CActionRobotMovement2D;

COccupancyGridMap2D::Ptr convert(const OccupancyGrid& map, std::size_t rays_per_beam) {
  const double right = map.origin.x + static_cast<double>(map.width) * map.resolution_m;
  const double top = map.origin.y + static_cast<double>(map.height) * map.resolution_m;
  auto grid = COccupancyGridMap2D::Create(static_cast<float>(map.origin.x), static_cast<float>(right),
                                          static_cast<float>(map.origin.y), static_cast<float>(top),
                                          static_cast<float>(map.resolution_m));
  for (std::size_t row = 0; row < map.height; ++row)
    for (std::size_t column = 0; column < map.width; ++column) {
      const auto cell = map.at(column, row);
      grid->setCell(static_cast<int>(column), static_cast<int>(row),
                    cell < 0 ? 0.5F : 1.0F - static_cast<float>(cell) / 100);
    }
  auto& options = grid->likelihoodOptions;
  options.likelihoodMethod = COccupancyGridMap2D::lmLikelihoodField_Thrun;
  options.LF_stdHit = 0.2F;
  options.LF_zHit = 0.95F;
  options.LF_zRandom = 0.05F;
  options.LF_maxRange = 80;
  options.LF_maxCorrsDistance = 0.6F;  // three sigma
  options.LF_decimation = static_cast<uint32_t>(rays_per_beam);
  return grid;
}

class MrptPeer : public Peer {
 public:
  MrptPeer(const OccupancyGrid& map, int min_particles, int max_particles, std::size_t rays_per_beam)
      : max_particles_(static_cast<std::size_t>(max_particles)), grid_(convert(map, rays_per_beam)) {
    pdf_.options.metricMap = grid_;
    pdf_.options.KLD_params.KLD_minSampleSize = static_cast<unsigned>(min_particles);
    pdf_.options.KLD_params.KLD_maxSampleSize = static_cast<unsigned>(max_particles);
    pdf_.options.KLD_params.KLD_binSize_XY = 0.5;
    filter_.m_options.PF_algorithm = CParticleFilter::pfStandardProposal;
    filter_.m_options.adaptiveSampleSize = min_particles < max_particles;
    filter_.m_options.resamplingMethod =
        min_particles < max_particles ? CParticleFilter::prMultinomial : CParticleFilter::prSystematic;
    filter_.m_options.sampleSize = static_cast<unsigned>(max_particles);
    mrpt::random::getRandomGenerator().randomize(1);
  }

  void begin_at(const Pose2& pose, double sigma_m, double sigma_rad) override {
    auto& random = mrpt::random::getRandomGenerator();
    pdf_.resetDeterministic({pose.x, pose.y, pose.yaw}, max_particles_);
    for (auto& particle : pdf_.m_particles) {
      particle.d.x += random.drawGaussian1D(0, sigma_m);
      particle.d.y += random.drawGaussian1D(0, sigma_m);
      particle.d.phi += random.drawGaussian1D(0, sigma_rad);
    }
  }

  void initialize_globally() override {
    pdf_.resetUniformFreeSpace(grid_.get(), 0.7, static_cast<int>(max_particles_));
  }

  void update(const LaserScan& scan, const Pose2& motion) override {
    CActionRobotMovement2D moved;
    // MRPT's own noise. Its other model (Thrun's) splits a rotation on the spot, or a motion backwards, into
    // two rotations of up to pi and makes noise of both: with as much of it as ours by default, it loses the
    // robot.
    moved.computeFromOdometry({motion.x, motion.y, motion.yaw}, {});
    mrpt::obs::CActionCollection actions;
    actions.insert(moved);
    mrpt::obs::CSensoryFrame frame;
    frame.insert(convert_scan(scan));
    filter_.executeOn(pdf_, &actions, &frame);
  }

  [[nodiscard]] Pose2 pose() const override {
    const auto mean = pdf_.getMeanVal();
    return {mean.x(), mean.y(), mean.phi()};
  }

 private:
  static mrpt::obs::CObservation2DRangeScan::Ptr convert_scan(const LaserScan& scan) {
    auto observation = mrpt::obs::CObservation2DRangeScan::Create();
    const std::size_t rays = scan.ranges.size();
    observation->resizeScan(rays);
    observation->aperture =
        static_cast<float>(std::abs(scan.angle_increment) * static_cast<double>(rays - 1));
    observation->rightToLeft = true;
    observation->maxRange = static_cast<float>(scan.range_max);
    const double middle = scan.angle_min + scan.angle_increment * static_cast<double>(rays - 1) / 2;
    observation->sensorPose = mrpt::poses::CPose3D(scan.base_T_sensor.x, scan.base_T_sensor.y, 0,
                                                   scan.base_T_sensor.yaw + middle, 0, 0);
    for (std::size_t i = 0; i < rays; ++i) {
      const float range = scan.ranges[i];
      const bool good = range > scan.range_min && range < scan.range_max;
      observation->setScanRange(i, good ? range : 0);
      observation->setScanRangeValidity(i, good);
    }
    return observation;
  }

  std::size_t max_particles_;
  COccupancyGridMap2D::Ptr grid_;
  mrpt::slam::CMonteCarloLocalization2D pdf_;
  CParticleFilter filter_;
};

}  // namespace

std::unique_ptr<Peer> Peer::make(const OccupancyGrid& map, int min_particles, int max_particles,
                                 std::size_t rays_per_beam) {
  return std::make_unique<MrptPeer>(map, min_particles, max_particles, rays_per_beam);
}

}  // namespace extperfc::benchmark
