#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "extperfc/base/math.hpp"
#include "extperfc/scan/cloud_to_scan.hpp"

namespace extperfc::scan {

namespace {

constexpr std::array kGroundMethods{
    std::pair{GroundMethod::kNone, "none"}, std::pair{GroundMethod::kHeight, "height"},
    std::pair{GroundMethod::kPlane, "plane"}, std::pair{GroundMethod::kSlope, "slope"}};
constexpr std::array kAzimuthTimes{std::pair{AzimuthTimes::kNone, "none"},
                                   std::pair{AzimuthTimes::kStampAtEnd, "end"},
                                   std::pair{AzimuthTimes::kStampAtStart, "start"}};
constexpr std::array kIntensities{
    std::pair{IntensityOf::kNone, "none"}, std::pair{IntensityOf::kNearest, "nearest"},
    std::pair{IntensityOf::kMaximum, "maximum"}, std::pair{IntensityOf::kHeight, "height"}};

template <typename Table, typename Value>
const char* name_in(const Table& table, Value value) {
  for (const auto& [known, name] : table)
    if (known == value) return name;
  return "?";
}

template <typename Value, typename Table>
Result<Value> value_in(const Table& table, const char* what, const std::string& name) {
  std::string names;
  for (const auto& [value, known] : table) {
    if (name == known) return value;
    names += (names.empty() ? "" : ", ") + std::string(known);
  }
  return fail(ErrorCode::kInvalidArgument,
              std::string("unknown ") + what + " '" + name + "'; use one of: " + names);
}

struct Bounded {
  const char* name;
  double value;
  double low;
  double high;
};

template <std::size_t N>
Result<void> all_inside(const std::array<Bounded, N>& numbers) {
  for (const auto& n : numbers)
    if (!(n.value >= n.low && n.value <= n.high))  // NaN fails too
      return fail(ErrorCode::kInvalidArgument, std::string(n.name) + " = " + std::to_string(n.value) +
                                                   " is out of its range [" + std::to_string(n.low) + ", " +
                                                   std::to_string(n.high) + "]");
  return {};
}

Result<void> validate_ground(const GroundParams& ground) {
  return all_inside(std::array<Bounded, 7>{{{"ground_z_m", ground.z_m, -10, 10},
                                            {"ground_clearance_m", ground.clearance_m, 0, 1},
                                            {"ground_band_m", ground.band_m, 0.001, 2},
                                            {"ground_max_slope_rad", ground.max_slope_rad, 0.001, 0.7},
                                            {"ground_inlier_m", ground.inlier_m, 0.001, 0.5},
                                            {"ground_max_iterations", 1.0 * ground.max_iterations, 1, 10000},
                                            {"ground_min_points", 1.0 * ground.min_points, 3, 100000}}});
}

Result<void> wrong(const std::string& message) {
  return fail(ErrorCode::kInvalidArgument, message);
}

}  // namespace

Result<GroundMethod> ground_method_from_name(const std::string& name) {
  return value_in<GroundMethod>(kGroundMethods, "ground_method", name);
}

const char* to_string(GroundMethod method) {
  return name_in(kGroundMethods, method);
}

Result<IntensityOf> intensity_from_name(const std::string& name) {
  return value_in<IntensityOf>(kIntensities, "intensity", name);
}

const char* to_string(IntensityOf intensity) {
  return name_in(kIntensities, intensity);
}

Result<AzimuthTimes> azimuth_times_from_name(const std::string& name) {
  return value_in<AzimuthTimes>(kAzimuthTimes, "azimuth_times", name);
}

const char* to_string(AzimuthTimes times) {
  return name_in(kAzimuthTimes, times);
}

Result<void> validate(const ScanParams& params) {
  constexpr double kFar = 1e6;  // users who want no limit write large numbers
  auto inside = all_inside(std::array<Bounded, 12>{{{"min_height", params.min_height, -kFar, kFar},
                                                    {"max_height", params.max_height, -kFar, kFar},
                                                    {"angle_min", params.angle_min, -2 * kPi, 2 * kPi},
                                                    {"angle_max", params.angle_max, -2 * kPi, 2 * kPi},
                                                    {"angle_increment", params.angle_increment, 1e-4, 1},
                                                    {"range_min", params.range_min, 0, kFar},
                                                    {"range_max", params.range_max, 0, kFar},
                                                    {"inf_epsilon", params.inf_epsilon, 0, kFar},
                                                    {"support_m", params.support_m, 0.001, 2},
                                                    {"range_noise_m", params.range_noise_m, 0, 0.1},
                                                    {"no_return_range", params.no_return_range, 0, kFar},
                                                    {"scan_time", params.scan_time, 0, 60}}});
  if (!inside) return inside;
  if (params.min_height > params.max_height) return wrong("min_height is greater than max_height");
  if (params.range_min > params.range_max) return wrong("range_min is greater than range_max");
  if (params.angle_min > params.angle_max) return wrong("angle_min is greater than angle_max");
  if (params.azimuth_times != AzimuthTimes::kNone && params.scan_time <= 0)
    return wrong("azimuth_times needs scan_time, the duration of one revolution");
  if (params.angle_max - params.angle_min > 2 * kPi + 1e-6)
    return wrong("angle_max - angle_min is more than one revolution");
  return validate_ground(params.ground);
}

}  // namespace extperfc::scan
