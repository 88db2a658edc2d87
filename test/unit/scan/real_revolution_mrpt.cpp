// Decodes the raw packets (VLP-16 user manual 63-9243, section 9.3). MRPT's own decoder leaves out the second
// of the two firings of every block, which is half of the points.
#include <cmath>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <string>

#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/serialization/CArchive.h>

#include "extperfc/base/math.hpp"

#include "test/unit/scan/real_revolution.hpp"

namespace extperfc::scan {

namespace {

using mrpt::obs::CObservationVelodyneScan;

constexpr const char* kRecording = "/usr/share/mrpt/datasets/test_velodyne_VLP16.rawlog";
constexpr double kFiringS = 55.296e-6;  // from firing to firing
constexpr double kLaserS = 2.304e-6;    // from laser to laser
constexpr int kLasers = 16;

/// Laser numbers go up in the order of firing: -15, 1, -13, 3, ... 15 degrees.
int elevation_deg(int laser) {
  return laser % 2 == 0 ? laser - 15 : laser;
}

VelodynePoint decode(int laser, double range_m, double intensity, double azimuth_rad, double time_s) {
  const double elevation = elevation_deg(laser) * kDegree;
  const double range = range_m > 0 ? range_m : std::numeric_limits<double>::quiet_NaN();
  VelodynePoint point{};
  point.x = static_cast<float>(range * std::cos(elevation) * std::cos(azimuth_rad));
  point.y =
      static_cast<float>(-range * std::cos(elevation) * std::sin(azimuth_rad));  // azimuths are clockwise
  point.z = static_cast<float>(range * std::sin(elevation));
  point.intensity = static_cast<float>(intensity);
  point.ring = static_cast<std::uint16_t>((elevation_deg(laser) + 15) / 2);
  point.time = static_cast<float>(time_s);
  return point;
}

/// One firing of all lasers; `rate` in rad per firing.
void add_firing(const CObservationVelodyneScan::raw_block_t& block, int firing_of_block, std::size_t firing,
                double azimuth, double rate, RealRevolution& revolution) {
  std::array<VelodynePoint, kLasers> row{};
  for (int laser = 0; laser < kLasers; ++laser) {
    const auto& beam = block.laser_returns[firing_of_block * kLasers + laser];
    const double since_firing_s = laser * kLaserS;
    const auto point =
        decode(laser, beam.distance() * CObservationVelodyneScan::DISTANCE_RESOLUTION, beam.intensity(),
               azimuth + rate * (firing_of_block + since_firing_s / kFiringS),
               static_cast<double>(firing) * kFiringS + since_firing_s);
    row[point.ring] = point;
  }
  revolution.points.insert(revolution.points.end(), row.begin(), row.end());
}

RealRevolution decode(const CObservationVelodyneScan& scan) {
  constexpr double kRate = 0.19907 * kDegree;  // 600 revolutions per minute
  RealRevolution revolution;
  for (const auto& packet : scan.scan_packets)
    for (const auto& block : packet.blocks)
      for (int firing = 0; firing < 2; ++firing)
        add_firing(block, firing, revolution.firings++, block.rotation() * 0.01 * kDegree, kRate, revolution);
  const float end = revolution.points.back().time;
  for (auto& point : revolution.points) point.time -= end;
  return revolution;
}

}  // namespace

RealRevolution read_real_revolution(std::string& why) {
  if (!std::filesystem::exists(kRecording)) {
    why = std::string(kRecording) + " is missing: install mrpt-common";
    return {};
  }
  mrpt::io::CFileGZInputStream file(kRecording);
  auto archive = mrpt::serialization::archiveFrom(file);
  const auto scan = std::dynamic_pointer_cast<CObservationVelodyneScan>(archive.ReadObject());
  if (!scan) throw std::runtime_error(std::string(kRecording) + " holds no Velodyne scan");
  return decode(*scan);
}

}  // namespace extperfc::scan
