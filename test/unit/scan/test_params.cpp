// Parameters: ranges, names, ring lists.
#include <functional>

#include <gtest/gtest.h>

#include "test/unit/scan/cloud_builder.hpp"

namespace extperfc::scan {
namespace {

TEST(ScanParams, DefaultsAreValid) {
  EXPECT_TRUE(validate(ScanParams{}));
  EXPECT_TRUE(CloudToScan::make(ScanParams{}));
  EXPECT_TRUE(validate(open_params()));
}

TEST(ScanParams, WhatCannotWorkIsNamed) {
  const std::vector<std::pair<const char*, std::function<void(ScanParams&)>>> wrong{
      {"min_height", [](auto& p) { p.min_height = 2, p.max_height = 1; }},
      {"angle_min", [](auto& p) { p.angle_min = 1, p.angle_max = 0; }},
      {"revolution", [](auto& p) { p.angle_min = -4, p.angle_max = 4; }},
      {"angle_increment", [](auto& p) { p.angle_increment = 0; }},
      {"angle_increment", [](auto& p) { p.angle_increment = std::nan(""); }},
      {"range_min", [](auto& p) { p.range_min = -1; }},
      {"range_min", [](auto& p) { p.range_min = 5, p.range_max = 4; }},
      {"inf_epsilon", [](auto& p) { p.inf_epsilon = -0.1; }},
      {"support_m", [](auto& p) { p.support_m = 0; }},
      {"range_noise_m", [](auto& p) { p.range_noise_m = 0.2; }},
      {"no_return_range", [](auto& p) { p.no_return_range = -1; }},
      {"scan_time", [](auto& p) { p.scan_time = 0, p.azimuth_times = AzimuthTimes::kStampAtEnd; }},
      {"ground_clearance_m", [](auto& p) { p.ground.clearance_m = -0.1; }},
      {"ground_max_slope_rad", [](auto& p) { p.ground.max_slope_rad = 0; }},
      {"ground_max_iterations", [](auto& p) { p.ground.max_iterations = 0; }},
      {"ground_min_points", [](auto& p) { p.ground.min_points = 2; }}};
  for (const auto& [name, spoil] : wrong) {
    ScanParams params;
    spoil(params);
    const auto refused = CloudToScan::make(params);
    ASSERT_FALSE(refused) << name;
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
    EXPECT_NE(refused.error().message.find(name), std::string::npos) << refused.error().message;
  }
}

TEST(ScanParams, NumberOfRays) {
  const auto rays = [](double from, double to, double step) {
    auto params = open_params();
    params.angle_min = from;
    params.angle_max = to;
    params.angle_increment = step;
    return CloudToScan::make(params)->rays();
  };
  EXPECT_EQ(rays(0, 0, 0.1), 1U);
  EXPECT_EQ(rays(0, 1, 0.1), 11U);
  EXPECT_EQ(rays(0, 1.05, 0.1), 11U);
  EXPECT_EQ(rays(-M_PI, M_PI, M_PI / 180), 360U);
  EXPECT_EQ(rays(-3.1415927, 3.1415927, 0.0174533), 360U) << "angles as people write them";
  EXPECT_EQ(rays(-M_PI / 2, M_PI / 2, M_PI / 360), 361U);
  EXPECT_EQ(rays(-3.1415, 3.1415, 0.0175), 360U);
}

TEST(ScanParams, NamesGoBothWays) {
  for (const auto method :
       {GroundMethod::kNone, GroundMethod::kHeight, GroundMethod::kPlane, GroundMethod::kSlope})
    EXPECT_EQ(ground_method_from_name(to_string(method)), method);
  for (const auto intensity :
       {IntensityOf::kNone, IntensityOf::kNearest, IntensityOf::kMaximum, IntensityOf::kHeight})
    EXPECT_EQ(intensity_from_name(to_string(intensity)), intensity);
  for (const auto times : {AzimuthTimes::kNone, AzimuthTimes::kStampAtEnd, AzimuthTimes::kStampAtStart})
    EXPECT_EQ(azimuth_times_from_name(to_string(times)), times);
  const auto unknown = ground_method_from_name("ransac");
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("none, height, plane, slope"), std::string::npos)
      << unknown.error().message;
}

TEST(RingSelection, ListsAndRanges) {
  const auto rings = parse_rings(" 1, 3,8-10 ");
  ASSERT_TRUE(rings) << rings.error().message;
  EXPECT_EQ(rings->count(), 5U);
  for (const std::size_t ring : {1, 3, 8, 9, 10}) EXPECT_TRUE(rings->test(ring)) << ring;
  EXPECT_EQ(parse_rings("0-255")->count(), 256U);
  EXPECT_EQ(parse_rings("")->count(), 0U);
}

TEST(RingSelection, WhatIsNoListIsRefused) {
  for (const char* text : {"256", "-1", "1-", "3-1", "a", "1;2", "1,,2", "1,", "0x1", "1.5", "1 - 2 - 3"}) {
    const auto refused = parse_rings(text);
    ASSERT_FALSE(refused) << text;
    EXPECT_NE(refused.error().message.find(text), std::string::npos) << refused.error().message;
  }
}

}  // namespace
}  // namespace extperfc::scan
