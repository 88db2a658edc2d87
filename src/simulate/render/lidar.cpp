#include "simulate/render/lidar.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/base/math.hpp"

namespace extperfc::simulate {

namespace {

// A packet is a patch of neighbouring columns and rings: its rays stay close together.
constexpr int kPatchColumns = 16;
constexpr int kPatchRings = kLanes / kPatchColumns;
static_assert(kRings % kPatchRings == 0);

constexpr double kFiringPeriod_s = 2.304e-6;  // from one laser to the next (VLP-16 manual)
constexpr float kHousing_m = 0.1F;            // the sensor does not see itself
constexpr std::uint32_t kLidarStream = 3;
/// Poses between two, a column apart: constant velocity and constant rotation.
class Motion {
 public:
  Motion(const Pose& begin, const Pose& end) : begin_(begin), step_(end.translation() - begin.translation()) {
    rotation_ = Eigen::AngleAxisd(begin.linear().transpose() * end.linear());
    moves_ = step_.norm() > 0.0 || std::abs(rotation_.angle()) > 1e-12;
  }

  [[nodiscard]] bool moves() const { return moves_; }
  [[nodiscard]] Eigen::Isometry3f at(double fraction) const {
    if (!moves_) return begin_.cast<float>();
    Pose pose = begin_;
    pose.translation() += fraction * step_;
    pose.linear() = begin_.linear() *
                    Eigen::AngleAxisd(fraction * rotation_.angle(), rotation_.axis()).toRotationMatrix();
    return pose.cast<float>();
  }

 private:
  Pose begin_;
  Eigen::Vector3d step_;
  Eigen::AngleAxisd rotation_;
  bool moves_{false};
};

/// [0, 255]: a diffuse white surface that is looked at squarely gives 100, as the sensor's calibration does.
float intensity(const Scene& scene, const RayPacket& packet, int k, float range) {
  const Hits& hit = packet.hit;
  const auto& record = scene.record(hit.mesh_instance[k], hit.triangle[k]);
  const float* r = scene.frame(hit.mesh_instance[k]).rotation;
  const float n[3] = {hit.normal_x[k], hit.normal_y[k], hit.normal_z[k]};
  float dot = 0;
  float length2 = 0;
  const float d[3] = {packet.ray.dir_x[k], packet.ray.dir_y[k], packet.ray.dir_z[k]};
  for (int i = 0; i < 3; ++i) {
    const float world = r[i] * n[0] + r[3 + i] * n[1] + r[6 + i] * n[2];
    dot += world * d[i];
    length2 += world * world;
  }
  const float cosine = length2 > 0.0F ? std::abs(dot) / std::sqrt(length2) : 1.0F;
  const TriangleSurface& surface = scene.surfaces()[record.surface];
  const float far = range * (1.0F / 80.0F);
  const float diffuse = 100.0F * surface.brightness * cosine / (1.0F + far * far);
  float mirrored = cosine * cosine;  // to the power of 32: gloss sends light back only when hit squarely
  for (int i = 0; i < 4; ++i) mirrored *= mirrored;
  const float back = diffuse + 60.0F * surface.gloss * mirrored;
  return std::clamp(std::round(back), 0.0F, 255.0F);
}

}  // namespace

double ring_elevation(int ring) {
  return (2 * ring - (kRings - 1)) * kPi / 180.0;
}

double ring_delay_s(int ring) {
  const int laser = ring < kRings / 2 ? 2 * ring : 2 * (ring - kRings / 2) + 1;
  return laser * kFiringPeriod_s;
}

void Lidar::aim(const LidarParams& params) {
  if (aimed_hz_ == params.rotation_hz && aimed_columns_ == params.columns) return;
  aimed_hz_ = params.rotation_hz;
  aimed_columns_ = params.columns;
  directions_.clear();
  times_.clear();
  poses_.resize(static_cast<std::size_t>(params.columns));
  returns_.resize(static_cast<std::size_t>(params.columns) * kRings);
  for (int column = 0; column < params.columns; ++column) {
    for (int ring = 0; ring < kRings; ++ring) {
      const double time_s = column / (params.columns * params.rotation_hz) + ring_delay_s(ring);
      const double azimuth = -2.0 * kPi * params.rotation_hz * time_s;  // clockwise seen from above
      const double elevation = ring_elevation(ring);
      directions_.push_back({static_cast<float>(std::cos(elevation) * std::cos(azimuth)),
                             static_cast<float>(std::cos(elevation) * std::sin(azimuth)),
                             static_cast<float>(std::sin(elevation))});
      times_.push_back(static_cast<float>(time_s));
    }
  }
}

struct Lidar::Sweep {
  const Scene& scene;
  NoiseKey key;
  int columns;
  float min_range, max_range, quantum, sigma, drop;
};

void Lidar::cast(const Sweep& sweep, int column, int ring) {
  for (int k = 0; k < kLanes; ++k) {
    const int c = std::min(column + k % kPatchColumns, sweep.columns - 1);
    const auto& pose = poses_[static_cast<std::size_t>(c)];
    const int firing = c * kRings + ring + k / kPatchColumns;
    const auto& d = directions_[static_cast<std::size_t>(firing)];
    const Eigen::Vector3f direction = pose.linear() * Eigen::Vector3f(d[0], d[1], d[2]);
    packet_.ray.org_x[k] = pose.translation().x();
    packet_.ray.org_y[k] = pose.translation().y();
    packet_.ray.org_z[k] = pose.translation().z();
    packet_.ray.dir_x[k] = direction.x();
    packet_.ray.dir_y[k] = direction.y();
    packet_.ray.dir_z[k] = direction.z();
    packet_.ray.near[k] = kHousing_m;
    packet_.ray.far[k] = sweep.max_range;
    packet_.ray.time[k] = 1.0F - static_cast<float>(c) / static_cast<float>(sweep.columns);
    packet_.hit.mesh_instance[k] = packet_.hit.geometry[k] = kNoHit;
    active_.on[k] = column + k % kPatchColumns < sweep.columns ? -1 : 0;
  }
  sweep.scene.rays().intersect(active_, true, packet_);
}

void Lidar::measure(const Sweep& sweep, int column, int ring) {
  for (int k = 0; k < kLanes; ++k) {
    if (active_.on[k] == 0) continue;
    const int firing = (column + k % kPatchColumns) * kRings + ring + k / kPatchColumns;
    Return& out = returns_[static_cast<std::size_t>(firing)];
    out = {0, 0};
    if (packet_.hit.mesh_instance[k] == kNoHit) continue;
    const auto counter = static_cast<std::uint32_t>(2 * firing);
    if (uniform(noise_bits(sweep.key, counter)) < sweep.drop) continue;
    const float noisy = packet_.ray.far[k] + sweep.sigma * gauss(noise_bits(sweep.key, counter + 1));
    const float range = std::floor(noisy / sweep.quantum + 0.5F) * sweep.quantum;
    if (range < sweep.min_range || range > sweep.max_range) continue;
    out = {range, intensity(sweep.scene, packet_, k, range)};
  }
}

void Lidar::sweep(const LidarParams& params, const Pose& world_T_begin, const Pose& world_T_end, Scene& scene,
                  std::uint64_t seed, double time_s, std::vector<LidarPoint>& points) {
  points.clear();
  if (params.columns <= 0 || !(params.rotation_hz > 0)) return;
  aim(params);
  clear(packet_.ray);
  clear(packet_.hit);
  const Motion motion(world_T_begin, world_T_end);
  if (motion.moves()) scene.trail_robot(world_T_begin * world_T_end.inverse());
  for (int column = 0; column < params.columns; ++column)
    poses_[static_cast<std::size_t>(column)] = motion.at(static_cast<double>(column) / params.columns);
  const Sweep sweep{scene,
                    noise_key(seed, params.sensor, time_s, kLidarStream),
                    params.columns,
                    static_cast<float>(params.min_range_m),
                    static_cast<float>(params.max_range_m),
                    static_cast<float>(std::max(params.quantum_m, 1e-6)),
                    static_cast<float>(params.range_noise_m),
                    static_cast<float>(params.drop_probability)};
  for (int column = 0; column < params.columns; column += kPatchColumns) {
    for (int ring = 0; ring < kRings; ring += kPatchRings) {
      cast(sweep, column, ring);
      measure(sweep, column, ring);
    }
  }
  points.reserve(directions_.size());
  for (std::size_t i = 0; i < returns_.size(); ++i) {
    const float range = returns_[i].range;
    if (range <= 0.0F) continue;
    const auto& d = directions_[i];
    points.push_back({range * d[0], range * d[1], range * d[2], returns_[i].intensity,
                      static_cast<std::uint16_t>(i % kRings), times_[i]});
  }
}

}  // namespace extperfc::simulate
