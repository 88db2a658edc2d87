#include "localize/pose_bins.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "extperfc/base/math.hpp"

namespace extperfc::localize {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::int64_t kBias = std::int64_t{1} << 27U;  // bins on either side of the map's corner

std::uint64_t pack(std::int64_t column, std::int64_t row, std::int64_t yaw_bin) {
  return static_cast<std::uint64_t>(column + kBias) << 36U | static_cast<std::uint64_t>(row + kBias) << 8U |
         static_cast<std::uint64_t>(yaw_bin);
}

std::uint64_t key_of(float x, float y, float yaw) {
  const auto bin = [](double v) {
    constexpr auto kLimit = static_cast<double>(kBias - 2);
    return static_cast<std::int64_t>(std::clamp(std::floor(v / kBinSide_m), -kLimit, kLimit));
  };
  const auto yaw_bin = static_cast<int>(std::floor((yaw + kPi) / kTwoPi * kBinsPerRevolution));
  return pack(bin(x), bin(y), (yaw_bin % kBinsPerRevolution + kBinsPerRevolution) % kBinsPerRevolution);
}

/// The key of a neighbouring bin.
std::uint64_t moved(std::uint64_t key, int columns, int rows, int yaw_bins) {
  const auto yaw_bin = (static_cast<int>(key & 0xffU) + yaw_bins + kBinsPerRevolution) % kBinsPerRevolution;
  const auto row = static_cast<std::int64_t>(key >> 8U & 0xfffffffU) - kBias + rows;
  const auto column = static_cast<std::int64_t>(key >> 36U) - kBias + columns;
  return pack(column, row, yaw_bin);
}

std::uint64_t mix(std::uint64_t key) {
  key ^= key >> 31U;
  key *= 0x9e3779b97f4a7c15U;
  return key ^ key >> 29U;
}

std::uint32_t root(std::vector<std::uint32_t>& parent, std::uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

}  // namespace

PoseBins::PoseBins(const ParticleSet& particles) {
  std::size_t slots = 16;
  while (slots < 2 * particles.size()) slots *= 2;
  slots_.assign(slots, kNone);
  bin_of_.reserve(particles.size());
  for (std::size_t i = 0; i < particles.size(); ++i)
    bin_of_.push_back(insert(key_of(particles.x[i], particles.y[i], particles.yaw[i])));
}

std::uint32_t PoseBins::insert(std::uint64_t key) {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = mix(key) & mask;
  while (slots_[slot] != kNone && keys_[slots_[slot]] != key) slot = (slot + 1) & mask;
  if (slots_[slot] == kNone) {
    slots_[slot] = static_cast<std::uint32_t>(keys_.size());
    keys_.push_back(key);
  }
  return slots_[slot];
}

std::uint32_t PoseBins::find(std::uint64_t key) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = mix(key) & mask;
  while (slots_[slot] != kNone && keys_[slots_[slot]] != key) slot = (slot + 1) & mask;
  return slots_[slot];
}

std::vector<std::uint32_t> PoseBins::clusters() const {
  std::vector<std::uint32_t> parent(keys_.size());
  std::iota(parent.begin(), parent.end(), 0U);
  for (std::uint32_t bin = 0; bin < keys_.size(); ++bin)
    for (int offset = 14; offset < 27; ++offset) {  // half of the 26 neighbours: the others find this one
      const std::uint32_t other = find(moved(keys_[bin], offset / 9 - 1, offset / 3 % 3 - 1, offset % 3 - 1));
      if (other != kNone) parent[root(parent, other)] = root(parent, bin);
    }
  for (std::uint32_t bin = 0; bin < parent.size(); ++bin) parent[bin] = root(parent, bin);
  return parent;
}

std::vector<Cluster> list_clusters(const ParticleSet& particles, const PoseBins& bins,
                                   const std::vector<std::uint32_t>& cluster_of_bin,
                                   const std::vector<float>& logs) {
  std::vector<Cluster> clusters(cluster_of_bin.size());
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const std::uint32_t number = cluster_of_bin[bins.bin_of()[i]];
    Cluster& cluster = clusters[number];
    if (cluster.particles == 0 || logs[i] > logs[cluster.best]) cluster.best = i;
    cluster.number = number;
    cluster.weight += particles.weight[i];
    ++cluster.particles;
  }
  const auto empty = [](const Cluster& cluster) { return cluster.particles == 0; };
  clusters.erase(std::remove_if(clusters.begin(), clusters.end(), empty), clusters.end());
  std::stable_sort(clusters.begin(), clusters.end(),
                   [](const Cluster& a, const Cluster& b) { return a.weight > b.weight; });
  return clusters;
}

PoseEstimate heaviest_cluster(const ParticleSet& particles, const PoseBins& bins) {
  const auto cluster = bins.clusters();
  std::vector<double> weight(cluster.size(), 0);
  for (std::size_t i = 0; i < particles.size(); ++i) weight[cluster[bins.bin_of()[i]]] += particles.weight[i];
  const auto best =
      static_cast<std::uint32_t>(std::max_element(weight.begin(), weight.end()) - weight.begin());
  const auto belongs = [&](std::size_t i) { return cluster[bins.bin_of()[i]] == best; };

  Eigen::Vector4d sum = Eigen::Vector4d::Zero();  // x, y, cosine, sine
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (!belongs(i)) continue;
    const double yaw = particles.yaw[i];
    sum += double{particles.weight[i]} *
           Eigen::Vector4d(particles.x[i], particles.y[i], std::cos(yaw), std::sin(yaw));
  }
  PoseEstimate estimate;
  estimate.cluster_weight = std::min(1.0, weight[best]);
  estimate.pose = {sum[0] / weight[best], sum[1] / weight[best], std::atan2(sum[3], sum[2])};
  estimate.covariance.setZero();
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (!belongs(i)) continue;
    const Eigen::Vector3d off(particles.x[i] - estimate.pose.x, particles.y[i] - estimate.pose.y,
                              wrap_angle(particles.yaw[i] - estimate.pose.yaw));
    estimate.covariance += particles.weight[i] / weight[best] * off * off.transpose();
  }
  return estimate;
}

}  // namespace extperfc::localize
