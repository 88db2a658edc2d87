#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/collision_guard.hpp"
#include "extperfc/navigate/near_memory.hpp"

#include "test/support/drive_simulation.hpp"

namespace extperfc::navigate {
namespace {

using Points = std::vector<Eigen::Vector2d>;

constexpr double kReach_m = 0.06;
constexpr double kSelf_m = 0.03;  // nearer to the chassis the scan shows nothing
constexpr double kSide_m = 0.3937;

class NearMemoryTest : public ::testing::Test {
 protected:
  NearMemory memory_{kReach_m};
  Footprint footprint_ = chassis();

  /// A wall on the left at y = wall_m of odom, as a scan shows it to the base at y.
  Points wall(double wall_m, double y, double noise_m = 0) {
    Points points;
    for (double x = -1; x <= 1; x += 0.01) {
      const double left_m = wall_m - y + noise_m * rng_.uniform(-1, 1);
      if (left_m > kSide_m + kSelf_m || std::abs(x) > 0.4064 + kSelf_m) points.emplace_back(x, left_m);
    }
    return points;
  }

  /// The time until the base touches the wall at 0.1 m/s to the left.
  std::optional<double> time_s(const Points& points) const {
    return time_to_contact(points, footprint_, 0.003, {0, 0.1, 0}, 2);
  }

 private:
  Rng rng_{7};
};

TEST_F(NearMemoryTest, AWallThatTheScanLosesStopsTheBase) {
  constexpr double kWall_m = kSide_m + 0.1;
  for (double y = 0; y < 0.09; y += 0.01) {
    auto points = wall(kWall_m, y);
    const bool seen = time_s(points).has_value();
    memory_.complete(points, footprint_, {3, y, 0});
    const auto contact_s = time_s(points);
    ASSERT_TRUE(contact_s) << y;
    EXPECT_LT(*contact_s, (0.097 - y) / 0.1 + 0.02) << y;
    EXPECT_GE(*contact_s, std::max(0.0, (0.097 - 0.016 - y) / 0.1 - 0.02)) << y;
    EXPECT_TRUE(seen || y > 0.065) << y;
    EXPECT_FALSE(seen && y > 0.075) << "the scan alone would do: the test shows nothing";
  }
}

TEST_F(NearMemoryTest, StaysWhileTheBaseStands) {
  auto points = wall(kSide_m + 0.04, 0);
  memory_.complete(points, footprint_, {});
  for (int i = 0; i < 1000; ++i) {
    points = wall(kSide_m + 0.04, 0.02);
    memory_.complete(points, footprint_, {0, 0.02, 0});
  }
  EXPECT_TRUE(time_s(points));
  EXPECT_LT(points.size(), 250U) << "bounded";
}

TEST_F(NearMemoryTest, WhatTheScanShowsTakesThePlaceOfWhatIsRemembered) {
  for (int i = 0; i < 500; ++i) {
    auto points = wall(kSide_m + 0.05, 0, 0.015);
    const std::size_t shown = points.size();
    memory_.complete(points, footprint_, {});
    EXPECT_EQ(points.size(), shown) << "noise does not gather";
  }
}

TEST_F(NearMemoryTest, LeavesItBehind) {
  auto points = wall(kSide_m + 0.04, 0);
  memory_.complete(points, footprint_, {});
  points.clear();
  memory_.complete(points, footprint_, {0, 0.02, 0});
  ASSERT_FALSE(points.empty());
  points.clear();
  memory_.complete(points, footprint_, {0, -0.05, 0});
  EXPECT_TRUE(points.empty()) << "outside of the strip the scan would show it";
  memory_.complete(points, footprint_, {0, 0.02, 0});
  EXPECT_TRUE(points.empty()) << "forgotten for good";
}

TEST_F(NearMemoryTest, NothingIsDeepInsideTheBase) {
  Points points = {{0, kSide_m + 0.01}};
  memory_.complete(points, footprint_, {});
  points.clear();
  memory_.complete(points, footprint_, {0, 0.03, 0});
  EXPECT_EQ(points.size(), 1U) << "noise and odometry explain 2 cm";
  points.clear();
  memory_.complete(points, footprint_, {0, 0.08, 0});
  EXPECT_TRUE(points.empty());
}

TEST_F(NearMemoryTest, RotatesWithTheBase) {
  Points points = {{0.4064 + 0.04, 0.1}};
  memory_.complete(points, footprint_, {1, 2, 0.5});
  points.clear();
  memory_.complete(points, footprint_, {1, 2, 0.6});
  ASSERT_EQ(points.size(), 1U);
  const Eigen::Vector2d seen(0.4464 * std::cos(0.1) + 0.1 * std::sin(0.1),
                             -0.4464 * std::sin(0.1) + 0.1 * std::cos(0.1));
  EXPECT_NEAR((points[0] - seen).norm(), 0.015, 1e-9);
  EXPECT_NEAR(points[0].norm(), seen.norm() - 0.015, 1e-9);
}

TEST_F(NearMemoryTest, OffAndBadInput) {
  NearMemory off(0);
  auto points = wall(kSide_m + 0.04, 0);
  off.complete(points, footprint_, {});
  points.clear();
  off.complete(points, footprint_, {});
  EXPECT_TRUE(points.empty());
  points = {{0, std::nan("")}, {std::numeric_limits<double>::infinity(), 0}};
  memory_.complete(points, footprint_, {});
  EXPECT_EQ(points.size(), 2U);
  memory_.complete(points, footprint_, {std::nan(""), 0, 0});
  EXPECT_EQ(points.size(), 2U);
  EXPECT_THROW(NearMemory(-0.01), std::invalid_argument);
  EXPECT_THROW(NearMemory(0.6), std::invalid_argument);
  EXPECT_THROW(NearMemory(std::nan("")), std::invalid_argument);
}

}  // namespace
}  // namespace extperfc::navigate
