#include "sources/carmen_line.hpp"

#include <cmath>
#include <limits>

#include "extperfc/base/math.hpp"
#include "extperfc/base/number_reader.hpp"

namespace extperfc::sources {

namespace {

constexpr double kSickMaxRangeM = 81.8;  // an LMS delivers 81.83 m without a return
constexpr double kMaxRays = 100000;

tl::unexpected<Error> damaged(const std::string& what) {
  return fail(ErrorCode::kCorrupt, what);
}

/// Reads numbers until one is missing; then `good` is false and `complaint` says which.
class Fields {
 public:
  explicit Fields(std::string_view line) : tokens_(line) { (void)tokens_.token(); }

  double number(const char* name) {
    if (!complaint_.empty()) return 0;
    const auto value = tokens_.number();
    if (!value) complaint_ = std::string(name) + " is missing or not a number";
    return value.value_or(0);
  }

  std::size_t count(const char* name) {
    const double value = number(name);
    if (!complaint_.empty()) return 0;
    if (value >= 0 && value <= kMaxRays && value == std::floor(value)) return static_cast<std::size_t>(value);
    complaint_ = std::string(name) + " is not a number from 0 to 100,000";
    return 0;
  }

  Pose2 pose(const char* name) {
    const double x = number(name);
    const double y = number(name);
    return {x, y, wrap_angle(number(name))};
  }

  /// Ranges; from `max_range_m` on they are no return.
  std::vector<float> ranges(std::size_t n, double max_range_m) {
    std::vector<float> found;
    found.reserve(n);
    for (std::size_t i = 0; i < n && good(); ++i) {
      const double range = number("a range");
      found.push_back(range >= max_range_m ? std::numeric_limits<float>::infinity()
                                           : static_cast<float>(range));
    }
    return found;
  }

  [[nodiscard]] bool good() const { return complaint_.empty(); }
  [[nodiscard]] const std::string& complaint() const { return complaint_; }

 private:
  TokenReader tokens_;
  std::string complaint_;
};

/// Rays of a FLASER line say only how many they are.
double flaser_increment(std::size_t rays) {
  if (rays == 180 || rays == 181) return kDegree;
  if (rays == 360 || rays == 361) return kDegree / 2;
  return kPi / static_cast<double>(rays - 1);
}

}  // namespace

Result<ScanRecord> parse_flaser(std::string_view line, double laser_offset_m, const ScanLogOptions& options) {
  Fields fields(line);
  ScanRecord record;
  LaserScan& scan = record.scan;
  const std::size_t rays = fields.count("the number of ranges");
  if (fields.good() && rays < 2) return damaged("a FLASER line of fewer than 2 ranges");
  scan.range_max = options.max_range_m > 0 ? options.max_range_m : kSickMaxRangeM;
  scan.ranges = fields.ranges(rays, scan.range_max);
  (void)fields.pose("the laser's pose");
  record.odom_T_base = fields.pose("the odometry's pose");
  scan.stamp_s = fields.number("the time stamp");
  if (!fields.good()) return damaged(fields.complaint());
  scan.angle_min = -kPi / 2;
  scan.angle_increment = flaser_increment(rays);
  scan.base_T_sensor = options.base_T_sensor.value_or(Pose2{laser_offset_m, 0, 0});
  return record;
}

Result<ScanRecord> parse_robotlaser(std::string_view line, const ScanLogOptions& options) {
  Fields fields(line);
  ScanRecord record;
  LaserScan& scan = record.scan;
  (void)fields.number("the laser's type");
  scan.angle_min = fields.number("the start angle");
  const double field_of_view = fields.number("the field of view");
  scan.angle_increment = fields.number("the angular resolution");
  const double said_max = fields.number("the maximum range");
  (void)fields.number("the accuracy");
  (void)fields.number("the remission mode");
  const std::size_t rays = fields.count("the number of ranges");
  if (fields.good() && rays < 2) return damaged("a ROBOTLASER1 line of fewer than 2 ranges");
  scan.range_max = options.max_range_m > 0 ? options.max_range_m : said_max > 0 ? said_max : kSickMaxRangeM;
  scan.ranges = fields.ranges(rays, scan.range_max);
  const std::size_t remissions = fields.count("the number of remissions");
  for (std::size_t i = 0; i < remissions && fields.good(); ++i) (void)fields.number("a remission");
  const Pose2 laser = fields.pose("the laser's pose");
  record.odom_T_base = fields.pose("the robot's pose");
  for (const char* name :
       {"the speed", "the angular velocity", "a safety distance", "a safety distance", "the rotation axis"})
    (void)fields.number(name);
  scan.stamp_s = fields.number("the time stamp");
  if (!fields.good()) return damaged(fields.complaint());
  if (scan.angle_increment <= 0) scan.angle_increment = field_of_view / static_cast<double>(rays - 1);
  scan.base_T_sensor = options.base_T_sensor.value_or(between(*record.odom_T_base, laser));
  return record;
}

}  // namespace extperfc::sources
