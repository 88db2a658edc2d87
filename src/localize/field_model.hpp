#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "localize/beams.hpp"
#include "localize/distance_field.hpp"
#include "localize/particle_set.hpp"

namespace extperfc::localize {

/// Likelihood field (Probabilistic Robotics, table 6.3): a beam that ends at distance d from the nearest
/// obstacle has the likelihood z_hit * exp(-d^2 / (2 sigma^2)) + z_rand, relative to z_hit + z_rand.
///
/// Random readings are thus as likely as hits at 2.4 sigma, and not spread over the whole range of the sensor
/// as in the book. There one beam in an unmapped chair outweighs ten that fit; people and furniture are the
/// rule.
class FieldModel {
 public:
  FieldModel(double z_hit, double z_rand, double sigma_m, const DistanceField& field);

  /// Mean over the beams' end points of the logarithm of their likelihood, for every particle; in (-inf, 0].
  /// Takes every `every`-th beam. All 0 when there are no end points.
  void mean_logs(const DistanceField& field, const Beams& beams, const ParticleSet& particles,
                 std::vector<float>& result, std::size_t every = 1) const;

  [[nodiscard]] float log_of(std::uint8_t byte) const { return log_likelihood_[byte]; }

 private:
  std::array<float, 256> log_likelihood_{};  ///< by the field's byte
};

}  // namespace extperfc::localize
