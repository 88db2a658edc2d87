#pragma once

#include <cstdint>
#include <vector>

#include "extperfc/scan/cloud_view.hpp"
#include "extperfc/scan/ring_selection.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::scan {

/// Coordinates in the target frame, each in an array of its own: loops over one of them are quick.
struct CloudPoints {
  std::vector<float> x, y, z;    ///< [m]; NaN where the cloud has NaN
  std::vector<float> intensity;  ///< as long as x, or empty

  [[nodiscard]] std::size_t size() const { return x.size(); }
  void resize(std::size_t points, bool with_intensity);
};

/// Which part of a cloud is read.
struct ReadOptions {
  const RingSet* rings{nullptr};  ///< null: all; else the cloud must have a ring field
  bool intensity{false};          ///< ignored when the cloud has none
};

/// Precondition: validate(cloud) passed.
void read_points(const CloudView& cloud, const Pose& target_T_cloud, const ReadOptions& options,
                 CloudPoints& points);

}  // namespace extperfc::scan
