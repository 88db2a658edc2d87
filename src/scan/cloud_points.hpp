#pragma once

#include <cstdint>
#include <vector>

#include "extperfc/scan/cloud_view.hpp"
#include "extperfc/scan/ring_selection.hpp"
#include "extperfc/scan/sensor_track.hpp"

namespace extperfc::scan {

/// A cloud's points, as a structure of arrays: loops over one number are fast.
struct CloudPoints {
  std::vector<float> sensor_x, sensor_y, sensor_z;  ///< [m]; NaN where the cloud has NaN
  std::vector<float> x, y, z;                       ///< in the target frame [m], see put_in_place()
  std::vector<float> intensity;                     ///< as long as x, or empty
  std::vector<float> level;   ///< separates rings: they differ by 1 or more. The ring's number, or twice the
                              ///< elevation in degrees where the cloud has no rings
  std::vector<float> time_s;  ///< since the stamp; as long as x, or empty where unknown

  [[nodiscard]] std::size_t size() const { return x.size(); }
};

/// Which part of a cloud is read.
struct ReadOptions {
  const RingSet* rings{nullptr};  ///< null: all; else the cloud must have a ring field
  bool intensity{false};          ///< ignored when the cloud has none
  bool time{false};               ///< from the time field, or else from the azimuth
  AzimuthTimes azimuth_times{AzimuthTimes::kNone};
  double revolution_s{0.1};  ///< of one revolution, for times from the azimuth
};

/// Fills everything but x, y and z. Precondition: validate(cloud) passed.
void read_points(const CloudView& cloud, const ReadOptions& options, CloudPoints& points);

}  // namespace extperfc::scan
