#pragma once

#include <cstdint>
#include <vector>

#include "extperfc/localize/localizer.hpp"

#include "localize/particle_set.hpp"

namespace extperfc::localize {

constexpr double kBinSide_m = 0.5;
constexpr int kBinsPerRevolution = 36;

/// Particles sorted into bins of 0.5 m x 0.5 m x 10 degrees, and neighbouring bins joined to clusters.
class PoseBins {
 public:
  explicit PoseBins(const ParticleSet& particles);

  [[nodiscard]] std::size_t bins() const { return keys_.size(); }
  [[nodiscard]] const std::vector<std::uint32_t>& bin_of() const { return bin_of_; }  ///< by particle
  /// A number per bin; bins of one cluster have the same. Bins touch by a side, an edge or a corner.
  [[nodiscard]] std::vector<std::uint32_t> clusters() const;

 private:
  [[nodiscard]] std::uint32_t find(std::uint64_t key) const;
  std::uint32_t insert(std::uint64_t key);

  std::vector<std::uint32_t> bin_of_;
  std::vector<std::uint64_t> keys_;   ///< by bin
  std::vector<std::uint32_t> slots_;  ///< open addressing, a power of two of them
};

struct Cluster {
  std::uint32_t number{0};  ///< as in PoseBins::clusters()
  double weight{0};         ///< sum of its particles' weights
  std::size_t particles{0};
  std::size_t best{0};  ///< number of the particle with the largest log likelihood
};
/// Every cluster, the heaviest first. `logs`: of the particles' likelihoods.
[[nodiscard]] std::vector<Cluster> list_clusters(const ParticleSet& particles, const PoseBins& bins,
                                                 const std::vector<std::uint32_t>& cluster_of_bin,
                                                 const std::vector<float>& logs);

/// Mean, covariance (both along the map's own axes, from its lower left corner) and weight of the heaviest
/// cluster. `fit` and `resampled` stay as they are by default. There must be a particle.
[[nodiscard]] PoseEstimate heaviest_cluster(const ParticleSet& particles, const PoseBins& bins);

}  // namespace extperfc::localize
