#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "extperfc/navigate/footprint.hpp"

namespace extperfc::navigate {

/// A footprint and smaller ones inside it. A grid shows an obstacle up to a cell too large, and a scan is
/// noisy: a base that stands in a narrow door seems to touch. How deep tells one from the other.
class ShrunkFootprints {
 public:
  /// Up to this margin cells and noise explain a contact [m].
  static constexpr std::size_t kExplained = 4;

  /// Does nothing when the footprint is the last one.
  void set(const Footprint& footprint);
  /// The smallest margin at which the footprint is free; size(): not even the smallest footprint is.
  [[nodiscard]] std::size_t depth(const CostGrid& costs, const Pose2& pose) const;
  [[nodiscard]] const Footprint& at(std::size_t depth) const { return footprints_[depth]; }
  [[nodiscard]] std::size_t size() const { return footprints_.size(); }

 private:
  static constexpr std::array<double, 11> kMargins_m{0,    0.015, 0.03, 0.045, 0.06, 0.09,
                                                     0.12, 0.16,  0.2,  0.25,  0.3};
  std::vector<Footprint> footprints_;
};

}  // namespace extperfc::navigate
