#include "sources/scan_rawlog.hpp"

#include <cmath>
#include <deque>
#include <exception>
#include <limits>
#include <string>
#include <utility>

#include <mrpt/core/Clock.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>

#include "extperfc/sources/scan_pairing.hpp"

#include "sources/mrpt_errors.hpp"

namespace extperfc::sources {

namespace {

namespace fs = std::filesystem;
using mrpt::obs::CObservation2DRangeScan;
using mrpt::obs::CObservationOdometry;

constexpr std::size_t kMaxComplaints = 10;
constexpr double kMaxTiltRad = 0.1;

Pose2 pose_of(const mrpt::poses::CPose2D& pose) {
  return {pose.x(), pose.y(), wrap_angle(pose.phi())};
}

/// A ray without echo is stored as invalid, most often with the largest range: no return. Other invalid
/// rays are unknown.
float range_of(const CObservation2DRangeScan& scan, std::size_t ray) {
  const float range = scan.getScanRange(ray);
  if (range >= scan.maxRange) return std::numeric_limits<float>::infinity();
  if (!scan.getScanRangeValidity(ray)) return std::numeric_limits<float>::quiet_NaN();
  return range;
}

/// kCorrupt when the scanner is tilted or the scan cannot be.
Result<LaserScan> scan_of(const CObservation2DRangeScan& observation, const ScanLogOptions& options) {
  const auto& sensor = observation.sensorPose;
  const bool upside_down = std::cos(sensor.roll()) * std::cos(sensor.pitch()) < 0;
  const double up = sensor.getRotationMatrix()(2, 2);
  if (std::acos(std::min(1.0, std::abs(up))) > kMaxTiltRad)
    return fail(ErrorCode::kCorrupt, "the scanner is tilted; only planar scans can be mapped");
  LaserScan scan;
  const std::size_t rays = observation.getScanSize();
  if (rays < 2) return fail(ErrorCode::kCorrupt, "a scan of fewer than 2 rays");
  scan.stamp_s =
      observation.timestamp == INVALID_TIMESTAMP ? 0.0 : mrpt::Clock::toDouble(observation.timestamp);
  // A scanner that hangs upside down rotates the other way round when seen from above.
  const double sense = observation.rightToLeft == upside_down ? -1.0 : 1.0;
  scan.angle_min = -sense * observation.aperture / 2;
  scan.angle_increment = sense * observation.aperture / static_cast<double>(rays - 1);
  scan.range_max = options.max_range_m > 0 ? options.max_range_m : observation.maxRange;
  const auto rotation = sensor.getRotationMatrix();
  scan.base_T_sensor = options.base_T_sensor.value_or(
      Pose2{sensor.x(), sensor.y(), std::atan2(rotation(1, 0), rotation(0, 0))});
  scan.ranges.reserve(rays);
  for (std::size_t ray = 0; ray < rays; ++ray) {
    const float range = range_of(observation, ray);
    scan.ranges.push_back(range >= static_cast<float>(scan.range_max) ? std::numeric_limits<float>::infinity()
                                                                      : range);
  }
  if (const auto valid = validate(scan); !valid) return tl::unexpected(valid.error());
  return scan;
}

/// A log of actions and what was seen after each, as against one of observations with stamps: its first
/// entries tell.
bool has_actions(const fs::path& file) {
  constexpr int kLook = 100;
  mrpt::io::CFileGZInputStream stream;
  if (!stream.open(file.string())) return false;
  mrpt::serialization::CArchiveStreamBase<mrpt::io::CFileGZInputStream> archive(stream);
  try {
    for (int i = 0; i < kLook; ++i)
      if (dynamic_cast<const mrpt::obs::CActionCollection*>(archive.ReadObject().get()) != nullptr)
        return true;
  } catch (const std::exception&) {
    return false;  // the end, or damage that the next read reports
  }
  return false;
}

class ScanRawlog : public ScanLog {
 public:
  ScanRawlog(fs::path file, const ScanLogOptions& options) : file_(std::move(file)), options_(options) {
    std::error_code ignored;
    bytes_ = static_cast<double>(fs::file_size(file_, ignored));
  }

  [[nodiscard]] bool open();
  Result<std::optional<ScanRecord>> next() override;
  [[nodiscard]] double progress() const override;
  [[nodiscard]] std::size_t damaged() const override { return damaged_; }
  [[nodiscard]] const std::vector<std::string>& complaints() const override { return complaints_; }

  /// Reads on until the first scan or the end: shows whether this is a rawlog at all. Throws std::exception.
  [[nodiscard]] Result<void> look();

 private:
  /// False at the regular end of the file. Throws std::exception when it is damaged.
  bool read_entry();
  void use(const mrpt::serialization::CSerializable::Ptr& entry);
  void use_action(const mrpt::obs::CActionCollection& actions);
  void use_observation(const mrpt::obs::CObservation& observation);
  void use_scan(const CObservation2DRangeScan& scan);
  void complain(const std::string& what);

  fs::path file_;
  ScanLogOptions options_;
  double bytes_{0};
  mrpt::io::CFileGZInputStream stream_;
  mrpt::serialization::CArchiveStreamBase<mrpt::io::CFileGZInputStream> archive_{stream_};
  ScanPairing pairing_;
  std::deque<ScanRecord> ready_;
  std::optional<Pose2> dead_reckoned_;  // sum of the actions' increments; no value in logs without actions
  std::size_t entries_{0};
  std::size_t scans_{0};
  std::size_t damaged_{0};
  bool at_end_{false};
  std::string broken_;
  std::vector<std::string> complaints_;
};

bool ScanRawlog::open() {
  if (has_actions(file_)) dead_reckoned_ = Pose2{};
  return stream_.open(file_.string());
}

bool ScanRawlog::read_entry() {
  try {
    const auto entry = archive_.ReadObject();
    ++entries_;
    use(entry);
    return true;
  } catch (const mrpt::serialization::CExceptionEOF&) {  // thrown between two entries only: the regular end
    return false;
  }
}

Result<std::optional<ScanRecord>> ScanRawlog::next() {
  while (ready_.empty() && !at_end_) {
    try {
      at_end_ = !read_entry();
    } catch (const std::exception& e) {
      at_end_ = true;
      broken_ = file_.string() +
                (entries_ == 0 ? " is no rawlog that MRPT can read: "
                               : " is damaged or breaks off after entry " + std::to_string(entries_) + ": ") +
                sentence_of(e);
    }
    if (at_end_) pairing_.finish();
    while (auto record = pairing_.take()) ready_.push_back(*std::move(record));
  }
  if (!ready_.empty()) {
    auto record = std::move(ready_.front());
    ready_.pop_front();
    return record;
  }
  if (!broken_.empty()) return fail(ErrorCode::kCorrupt, broken_);
  return std::optional<ScanRecord>();
}

Result<void> ScanRawlog::look() {
  auto first = next();
  if (!first) {
    if (entries_ > 0) return {};  // damaged later on: next() says so
    return tl::unexpected(first.error());
  }
  if (*first) ready_.push_front(**std::move(first));
  return {};
}

double ScanRawlog::progress() const {
  auto& stream = const_cast<mrpt::io::CFileGZInputStream&>(stream_);  // asks for a position only
  return bytes_ > 0 ? std::min(1.0, static_cast<double>(stream.getPosition()) / bytes_) : 1.0;
}

void ScanRawlog::use(const mrpt::serialization::CSerializable::Ptr& entry) {
  if (const auto* actions = dynamic_cast<const mrpt::obs::CActionCollection*>(entry.get()))
    use_action(*actions);
  if (const auto* moment = dynamic_cast<const mrpt::obs::CSensoryFrame*>(entry.get()))
    for (const auto& observation : *moment) use_observation(*observation);
  if (const auto* observation = dynamic_cast<const mrpt::obs::CObservation*>(entry.get()))
    use_observation(*observation);
}

void ScanRawlog::use_action(const mrpt::obs::CActionCollection& actions) {
  const auto movement = actions.getBestMovementEstimation();
  if (!movement || !dead_reckoned_) return;
  const bool raw = movement->estimationMethod == mrpt::obs::CActionRobotMovement2D::emOdometry;
  const auto step = raw ? movement->rawOdometryIncrementReading : movement->poseChange->getMeanVal();
  dead_reckoned_ = compose(*dead_reckoned_, pose_of(step));
}

void ScanRawlog::use_observation(const mrpt::obs::CObservation& observation) {
  if (const auto* scan = dynamic_cast<const CObservation2DRangeScan*>(&observation)) use_scan(*scan);
  if (const auto* odometry = dynamic_cast<const CObservationOdometry*>(&observation))
    if (odometry->timestamp != INVALID_TIMESTAMP)
      pairing_.add_odometry(mrpt::Clock::toDouble(odometry->timestamp), pose_of(odometry->odometry));
}

void ScanRawlog::use_scan(const CObservation2DRangeScan& observation) {
  if (scans_ == 0 && options_.sensor_label.empty()) options_.sensor_label = observation.sensorLabel;
  if (observation.sensorLabel != options_.sensor_label) return;
  const std::size_t index = scans_++;
  auto scan = scan_of(observation, options_);
  if (!scan) return complain(scan.error().message);
  ScanRecord record{*std::move(scan), dead_reckoned_, index};
  if (dead_reckoned_)
    ready_.push_back(std::move(record));
  else
    pairing_.add_scan(std::move(record));
}

void ScanRawlog::complain(const std::string& what) {
  ++damaged_;
  if (complaints_.size() < kMaxComplaints)
    complaints_.push_back(file_.filename().string() + " entry " + std::to_string(entries_) + ": " + what);
}

}  // namespace

}  // namespace extperfc::sources

extern "C" void extperfc_open_scan_rawlog(
    const std::filesystem::path& file, const extperfc::sources::ScanLogOptions& options,
    extperfc::Result<std::unique_ptr<extperfc::sources::ScanLog>>& opened) {
  using extperfc::ErrorCode;
  try {
    auto log = std::make_unique<extperfc::sources::ScanRawlog>(file, options);
    if (!log->open()) {
      opened = extperfc::fail(ErrorCode::kFailed, "cannot open " + file.string());
    } else if (auto looked = log->look(); !looked) {
      opened = tl::unexpected(looked.error());
    } else {
      opened = std::move(log);
    }
  } catch (const std::exception& e) {
    opened = extperfc::fail(ErrorCode::kFailed, file.string() + ": " + extperfc::sources::sentence_of(e));
  }
}
