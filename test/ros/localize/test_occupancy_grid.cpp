// nav_msgs/OccupancyGrid <-> the core's map.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "ros/convert/occupancy_grid.hpp"

namespace extperfc::ros_convert {
namespace {

OccupancyGrid random_map(Rng& rng) {
  OccupancyGrid map;
  map.width = static_cast<std::size_t>(rng.integer(1, 40));
  map.height = static_cast<std::size_t>(rng.integer(1, 40));
  map.resolution_m = 0.01 * rng.integer(1, 50);
  map.origin = {rng.uniform(-50, 50), rng.uniform(-50, 50), rng.uniform(-3.1, 3.1)};
  for (std::size_t i = 0; i < map.width * map.height; ++i)
    map.cells.push_back(static_cast<std::int8_t>(rng.integer(-1, 100)));
  return map;
}

TEST(OccupancyGridMessage, ThereAndBackIsTheSame) {
  Rng rng(1);
  for (int i = 0; i < 200; ++i) {
    const auto map = random_map(rng);
    std_msgs::Header header;
    header.frame_id = "map";
    header.stamp = ros::Time(7, 8);
    const auto message = to_message(map, header);
    EXPECT_EQ(message.header.frame_id, "map");
    EXPECT_EQ(message.info.map_load_time, header.stamp);
    const auto back = to_occupancy_grid(message);
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->width, map.width);
    EXPECT_EQ(back->height, map.height);
    EXPECT_DOUBLE_EQ(back->resolution_m, map.resolution_m) << "the decimal number, not the nearest float";
    EXPECT_NEAR(back->origin.x, map.origin.x, 1e-12);
    EXPECT_NEAR(back->origin.y, map.origin.y, 1e-12);
    EXPECT_NEAR(back->origin.yaw, map.origin.yaw, 1e-9);
    EXPECT_EQ(back->cells, map.cells);
  }
}

TEST(OccupancyGridMessage, BackAndThereIsTheSame) {
  nav_msgs::OccupancyGrid message;
  message.info.resolution = 0.0333333F;
  message.info.width = 3;
  message.info.height = 2;
  message.info.origin.orientation.w = 1;
  message.data = {-1, 0, 100, 50, 1, 99};
  const auto back = to_message(to_occupancy_grid(message).value(), message.header);
  EXPECT_EQ(back.info.resolution, message.info.resolution);
  EXPECT_EQ(back.data, message.data);
  EXPECT_EQ(back.info.origin.orientation.w, 1.0);
}

class BadMap : public testing::Test {
 protected:
  BadMap() {
    message_.info.resolution = 0.05F;
    message_.info.width = 4;
    message_.info.height = 3;
    message_.info.origin.orientation.w = 1;
    message_.data.resize(12);
  }
  void expect_error(const std::string& text) const {
    const auto map = to_occupancy_grid(message_);
    ASSERT_FALSE(map);
    EXPECT_NE(map.error().message.find(text), std::string::npos) << map.error().message;
  }
  nav_msgs::OccupancyGrid message_;
};

TEST_F(BadMap, GoodOneFirst) {
  EXPECT_TRUE(to_occupancy_grid(message_));
}

TEST_F(BadMap, WithoutCells) {
  message_.info.width = 0;
  expect_error("no cells");
}

TEST_F(BadMap, OfAnotherLength) {
  message_.data.pop_back();
  expect_error("says 4 x 3 cells, but brings 11");
}

TEST_F(BadMap, WhoseSizeOverflows) {
  message_.info.width = 0xffffffffU;
  message_.info.height = 0xffffffffU;
  expect_error("says 4294967295 x 4294967295 cells");
}

TEST_F(BadMap, WithoutAResolution) {
  for (const float resolution :
       {0.0F, -0.05F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    message_.info.resolution = resolution;
    expect_error("resolution");
  }
}

TEST_F(BadMap, WhoseOriginIsNotFinite) {
  message_.info.origin.position.x = std::numeric_limits<double>::quiet_NaN();
  expect_error("origin");
}

TEST_F(BadMap, WhoseOriginHasNoRotation) {
  message_.info.origin.orientation.w = 0;
  expect_error("length zero");
}

TEST_F(BadMap, ThatIsTilted) {
  message_.info.origin.orientation.x = 0.1;
  expect_error("tilted");
}

}  // namespace
}  // namespace extperfc::ros_convert
