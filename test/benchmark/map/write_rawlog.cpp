// Writes the first scans of a CARMEN log as an MRPT rawlog, for MRPT's programs. A program of its own, so
// that MRPT stays out of the process whose memory is measured. MRPT's own import takes 180 rays to be half a
// degree apart.

#include <cmath>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <limits>
#include <optional>
#include <string>

#include <mrpt/core/Clock.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>

#include "extperfc/sources/scan_log.hpp"

namespace extperfc::benchmark {
namespace {

mrpt::poses::CPose2D mrpt_pose(const Pose2& pose) {
  return {pose.x, pose.y, pose.yaw};
}

/// MRPT's default motion model.
mrpt::obs::CActionCollection action_of(const Pose2& step, const mrpt::Clock::time_point& stamp) {
  mrpt::obs::CActionRobotMovement2D movement;
  movement.computeFromOdometry(mrpt_pose(step), {});
  movement.timestamp = stamp;
  mrpt::obs::CActionCollection actions;
  actions.insert(movement);
  return actions;
}

mrpt::obs::CSensoryFrame frame_of(const LaserScan& scan, const mrpt::Clock::time_point& stamp) {
  auto observation = mrpt::obs::CObservation2DRangeScan::Create();
  observation->timestamp = stamp;
  observation->sensorLabel = "LASER";
  observation->rightToLeft = scan.angle_increment > 0;
  observation->aperture =
      static_cast<float>(std::abs(scan.angle_increment) * static_cast<double>(scan.ranges.size() - 1));
  observation->maxRange = static_cast<float>(scan.range_max);
  // MRPT's rays lie evenly about the sensor's x axis; ours need not: 180 rays go from -90 to 89 degrees.
  const double middle =
      scan.angle_min + scan.angle_increment * static_cast<double>(scan.ranges.size() - 1) / 2;
  observation->sensorPose = mrpt::poses::CPose3D(mrpt_pose(compose(scan.base_T_sensor, {0, 0, middle})));
  observation->resizeScan(scan.ranges.size());
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const float range = scan.ranges[i];
    const bool returned = range > 0 && range < observation->maxRange;  // false for NaN
    observation->setScanRange(i, returned ? range : observation->maxRange);
    observation->setScanRangeValidity(i, returned);
  }
  mrpt::obs::CSensoryFrame frame;
  frame.insert(observation);
  return frame;
}

/// Stamps are the scans' numbers: those of a log may run backwards.
int write(const std::string& from, const std::string& to, std::size_t max_scans) {
  auto log = sources::open_carmen_log(from);
  if (!log) throw std::runtime_error(log.error().message);
  mrpt::io::CFileGZOutputStream file;
  if (!file.open(to, 1)) throw std::runtime_error("cannot write " + to);
  auto archive = mrpt::serialization::archiveFrom(file);
  std::optional<Pose2> before;
  for (std::size_t i = 0; i < max_scans; ++i) {
    auto record = (*log)->next();
    if (!record) throw std::runtime_error(record.error().message);
    if (!*record) break;
    const Pose2 odometry = (*record)->odom_T_base.value_or(before.value_or(Pose2{}));
    const auto stamp = mrpt::Clock::fromDouble(1e9 + static_cast<double>(i));
    archive << action_of(before ? between(*before, odometry) : Pose2{}, stamp);
    archive << frame_of((*record)->scan, stamp);
    before = odometry;
  }
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace extperfc::benchmark

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: bench_map_rawlog LOG RAWLOG MAX_SCANS\n";
    return 2;
  }
  try {
    return extperfc::benchmark::write(argv[1], argv[2], std::strtoul(argv[3], nullptr, 10));
  } catch (const std::exception& error) {
    std::cerr << "bench_map_rawlog: " << error.what() << "\n";
    return EXIT_FAILURE;
  }
}
