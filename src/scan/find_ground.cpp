#include "scan/find_ground.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/sample_consensus/msac.h>
#include <pcl/sample_consensus/sac_model_plane.h>

namespace extperfc::scan {

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

/// PCL's plane model, with our seed, and strict about its samples: three points that are too close to a line
/// or span a steep plane are not tried at all. (PCL's own check writes to stderr at every such sample.)
class LevelPlane : public pcl::SampleConsensusModelPlane<pcl::PointXYZ> {
 public:
  LevelPlane(const Cloud::ConstPtr& cloud, const GroundParams& params)
      : SampleConsensusModelPlane(cloud), min_cosine_(static_cast<float>(std::cos(params.max_slope_rad))) {
    rng_alg_.seed(params.seed);
  }

 protected:
  // std::vector<int> is what PCL calls Indices from 1.11 on.
  bool isSampleGood(const std::vector<int>& samples) const override {
    if (samples.size() != 3) return false;
    const auto point = [&](std::size_t i) -> Eigen::Vector3f {
      return (*input_)[samples[i]].getVector3fMap();
    };
    const Eigen::Vector3f a = point(1) - point(0);
    const Eigen::Vector3f b = point(2) - point(0);
    const Eigen::Vector3f normal = a.cross(b);
    constexpr float kMinSine = 0.05F;  // of the angle between a and b
    return normal.norm() > kMinSine * a.norm() * b.norm() &&
           std::abs(normal.z()) >= min_cosine_ * normal.norm();
  }

 private:
  float min_cosine_;
};

bool in_band(const CloudPoints& points, std::size_t i, const GroundParams& params) {
  return std::abs(points.z[i] - static_cast<float>(params.z_m)) <= static_cast<float>(params.band_m) &&
         std::isfinite(points.x[i] + points.y[i]);
}

Cloud::Ptr candidates(const CloudPoints& points, const GroundParams& params) {
  constexpr std::size_t kMaxPoints = 1000;
  std::size_t all = 0;
  for (std::size_t i = 0; i < points.size(); ++i) all += in_band(points, i, params) ? 1 : 0;
  const std::size_t every = std::max<std::size_t>(1, (all + kMaxPoints - 1) / kMaxPoints);
  Cloud::Ptr cloud(new Cloud);
  cloud->reserve(all / every + 1);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (in_band(points, i, params) && seen++ % every == 0)
      cloud->push_back({points.x[i], points.y[i], points.z[i]});
  return cloud;
}

Ground upwards(const Eigen::VectorXf& coefficients) {
  const float sign = coefficients[2] < 0 ? -1.0F : 1.0F;
  return {sign * coefficients.head<3>(), sign * coefficients[3]};
}

}  // namespace

std::optional<Ground> find_ground(const CloudPoints& points, const GroundParams& params) {
  const auto cloud = candidates(points, params);
  if (cloud->size() < static_cast<std::size_t>(params.min_points)) return std::nullopt;
  const LevelPlane::Ptr model(new LevelPlane(cloud, params));
  pcl::MEstimatorSampleConsensus<pcl::PointXYZ> consensus(model, params.inlier_m);
  consensus.setMaxIterations(params.max_iterations);
  if (!consensus.computeModel()) return std::nullopt;
  std::vector<int> inliers;
  consensus.getInliers(inliers);
  if (inliers.size() < static_cast<std::size_t>(params.min_points)) return std::nullopt;
  Eigen::VectorXf best;
  consensus.getModelCoefficients(best);
  Eigen::VectorXf refined = best;
  model->optimizeModelCoefficients(inliers, best, refined);
  const Ground ground = upwards(refined);
  if (!ground.normal.allFinite() || ground.slope_rad() > params.max_slope_rad) return upwards(best);
  return ground;
}

double Ground::slope_rad() const {
  return std::acos(std::clamp<double>(normal.z(), -1.0, 1.0));
}

}  // namespace extperfc::scan
