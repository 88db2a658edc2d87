#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "extperfc/world/laser_scan.hpp"

namespace extperfc {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

LaserScan good_scan() {
  LaserScan scan;
  scan.angle_min = -M_PI / 2;
  scan.angle_increment = M_PI / 180;
  scan.range_min = 0.1;
  scan.range_max = 10;
  scan.ranges.assign(181, 2.0F);
  return scan;
}

std::string complaint(const LaserScan& scan) {
  const auto valid = validate(scan);
  return valid ? "" : valid.error().message;
}

TEST(LaserScan, CountsWhatMetSomething) {
  LaserScan scan = good_scan();
  scan.ranges = {0.1F, 10.0F, 5.0F,                                        // count
                 0.0F, -1.0F, 0.05F, 10.5F, kInfinity, -kInfinity, kNan};  // do not
  EXPECT_EQ(count_returns(scan), 3U);
  scan.range_min = 0;  // a range of zero is never a return
  EXPECT_EQ(count_returns(scan), 4U);
  scan.ranges.clear();
  EXPECT_EQ(count_returns(scan), 0U);
}

TEST(LaserScan, GoodScansAreGood) {
  EXPECT_EQ(complaint(good_scan()), "");
  LaserScan scan = good_scan();
  scan.angle_increment = -scan.angle_increment;  // hangs upside down
  scan.ranges.assign(181, kNan);                 // sees nothing
  EXPECT_EQ(complaint(scan), "");
  scan.ranges.assign(1, 1.0F);
  EXPECT_EQ(complaint(scan), "");
  scan.angle_increment = 2 * M_PI / 360;
  scan.ranges.assign(361, 1.0F);  // a full revolution, both ends
  EXPECT_EQ(complaint(scan), "");
}

TEST(LaserScan, ComplaintsNameTheField) {
  const auto with = [](auto change) {
    LaserScan scan = good_scan();
    change(scan);
    return complaint(scan);
  };
  const double nan = std::nan("");
  EXPECT_NE(with([&](auto& s) { s.angle_min = nan; }).find("angle_min"), std::string::npos);
  EXPECT_NE(with([&](auto& s) { s.angle_increment = HUGE_VAL; }).find("angle_increment"), std::string::npos);
  EXPECT_NE(with([](auto& s) { s.angle_increment = 0; }).find("angle_increment is 0"), std::string::npos);
  EXPECT_NE(with([](auto& s) { s.range_max = 0.1; }).find("range_max"), std::string::npos);
  EXPECT_NE(with([](auto& s) { s.range_min = -3, s.range_max = -1; }).find("range_max"), std::string::npos);
  EXPECT_NE(with([&](auto& s) { s.range_max = nan; }).find("range_max"), std::string::npos);
  EXPECT_NE(with([](auto& s) { s.ranges.clear(); }).find("no rays"), std::string::npos);
  EXPECT_NE(with([](auto& s) {
              s.angle_increment = 1e-5;
              s.ranges.assign(100001, 1.0F);
            }).find("100001 rays"),
            std::string::npos);
  EXPECT_NE(with([](auto& s) { s.angle_increment = 1; }).find("in radians"), std::string::npos);
  EXPECT_NE(with([](auto& s) { s.heights_m.assign(s.ranges.size() + 1, 0); }).find("heights"),
            std::string::npos);
  EXPECT_NE(with([&](auto& s) { s.base_T_sensor.yaw = nan; }).find("pose of the scanner"), std::string::npos);
}

TEST(LaserScan, ReturnsOnDiscsAreLeftOut) {
  LaserScan scan = good_scan();
  scan.base_T_sensor = {};
  scan.angle_min = 0;
  scan.angle_increment = M_PI / 2;
  scan.range_min = 0.1;
  scan.range_max = 10;
  scan.ranges = {2.0F, 2.0F, 2.0F, std::numeric_limits<float>::infinity()};
  const Pose2 frame_T_sensor{1, 0, M_PI / 2};  // rays end at (1, 2), (-1, 0), (1, -2)
  const LaserScan rest =
      without_discs(scan, {{{1, 2.2}, 0.3}, {{-1, 0.4}, 0.3}, {{3, 0}, 0.3}}, frame_T_sensor);
  EXPECT_TRUE(std::isnan(rest.ranges[0]));
  EXPECT_EQ(rest.ranges[1], 2.0F);
  EXPECT_EQ(rest.ranges[2], 2.0F);
  EXPECT_TRUE(std::isinf(rest.ranges[3])) << "what met nothing met no person";
  EXPECT_EQ(without_discs(scan, {}, frame_T_sensor).ranges, scan.ranges);
}

}  // namespace
}  // namespace extperfc
