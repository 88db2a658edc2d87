// Footprints: what is refused, radii, padding.
#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/footprint.hpp"

namespace extperfc::navigate {
namespace {

using Eigen::Vector2d;
using Corners = std::vector<Vector2d>;

const Corners kSquare{{-0.4, -0.4}, {0.4, -0.4}, {0.4, 0.4}, {-0.4, 0.4}};
const Corners kL{{-0.2, -0.2}, {0.6, -0.2}, {0.6, 0.2}, {0.2, 0.2}, {0.2, 0.6}, {-0.2, 0.6}};

double area_of(const Corners& corners) {
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto& a = corners[i];
    const auto& b = corners[(i + 1) % corners.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

/// By the winding number.
bool holds(const Corners& corners, const Vector2d& point) {
  double angle = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector2d a = corners[i] - point;
    const Vector2d b = corners[(i + 1) % corners.size()] - point;
    angle += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  }
  return std::abs(angle) > kPi;
}

/// A star about the origin: simple, with dents.
Corners random_star(Rng& rng) {
  const int n = rng.integer(3, 14);
  Corners corners;
  for (int i = 0; i < n; ++i) {
    const double angle = kTwoPi * (i + rng.uniform(-0.2, 0.2)) / n;
    corners.emplace_back(rng.uniform(0.2, 0.7) * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return corners;
}

TEST(Footprint, RadiiOfASquare) {
  const auto footprint = Footprint::make(kSquare).value();
  EXPECT_NEAR(footprint.inscribed_radius_m(), 0.4, 1e-12);
  EXPECT_NEAR(footprint.circumscribed_radius_m(), 0.4 * std::sqrt(2.0), 1e-12);
}

TEST(Footprint, EitherOrderAndRepeatedCorners) {
  Corners clockwise(kSquare.rbegin(), kSquare.rend());
  clockwise.push_back(clockwise.front());
  const auto footprint = Footprint::make(clockwise).value();
  EXPECT_EQ(footprint.corners_m().size(), 4U);
  EXPECT_NEAR(area_of(footprint.corners_m()), 0.64, 1e-12);
}

TEST(Footprint, RefusesWhatIsNoOutline) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<Corners, std::string>> wrong{
      {{}, "3 to 100"},
      {{{-1, 0}, {1, 0}}, "3 to 100"},
      {{{-1, 0}, {1, 0}, {-1, 0}, {1, 0}, {1, 0}}, "cross"},
      {Corners(101, Vector2d(1, 1)), "3 to 100"},
      {{{-1, -1}, {1, -1}, {nan, 1}}, "finite"},
      {{{-1, -1}, {1, 1}, {1, -1}, {-1, 1}}, "cross"},                    // a bow tie
      {{{-1, -1}, {1, -1}, {1, 1}, {0, -1}, {-1, 1}}, "cross or touch"},  // a corner on another edge
      {{{-1, -1}, {1, -1}, {3, -1}, {2, -1}, {1, 1}}, "cross or touch"},  // an edge back on itself
      {{{-0.001, -0.001}, {0.001, -0.001}, {0, 0.001}}, "area"},
      {{{-1, 0}, {0, 0}, {1, 0}}, "cross or touch"},
      {{{0.1, 0.1}, {1, 0.1}, {1, 1}}, "origin"},
      {{{-11, -1}, {1, -1}, {1, 1}}, "10 m"},
  };
  for (const auto& [corners, why] : wrong) {
    const auto made = Footprint::make(corners);
    ASSERT_FALSE(made) << why;
    EXPECT_EQ(made.error().code, ErrorCode::kInvalidArgument);
    EXPECT_NE(made.error().message.find(why), std::string::npos) << made.error().message;
  }
  Corners many;
  for (int i = 0; i < 101; ++i) many.emplace_back(std::cos(kTwoPi * i / 101), std::sin(kTwoPi * i / 101));
  EXPECT_FALSE(Footprint::make(many));
  many.pop_back();
  EXPECT_TRUE(Footprint::make(many));
}

TEST(Footprint, OriginOnAnEdgeIsAllowed) {
  const auto footprint = Footprint::make({{0, -0.3}, {0.8, -0.3}, {0.8, 0.3}, {0, 0.3}});
  ASSERT_TRUE(footprint);
  EXPECT_NEAR(footprint->inscribed_radius_m(), 0, 1e-12);
}

TEST(Footprint, CircleIsCovered) {
  const auto footprint = Footprint::circle(0.3);
  EXPECT_NEAR(footprint.inscribed_radius_m(), 0.3, 1e-12);
  EXPECT_LT(footprint.circumscribed_radius_m(), 0.3 * 1.02);
  EXPECT_EQ(footprint.corners_m().size(), 16U);
  EXPECT_THROW((void)Footprint::circle(0), std::invalid_argument);
  EXPECT_THROW((void)Footprint::circle(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
}

TEST(Footprint, PaddedSquareIsALargerSquare) {
  const auto padded = Footprint::make(kSquare)->padded(0.1);
  EXPECT_NEAR(padded.inscribed_radius_m(), 0.5, 1e-12);
  EXPECT_NEAR(area_of(padded.corners_m()), 1.0, 1e-12);
  const auto back = padded.padded(-0.1);
  EXPECT_NEAR(area_of(back.corners_m()), 0.64, 1e-12);
}

TEST(Footprint, PaddedLKeepsItsDent) {
  const auto footprint = Footprint::make(kL).value();
  const auto padded = footprint.padded(0.05);
  EXPECT_EQ(padded.corners_m().size(), 6U);
  EXPECT_NEAR(area_of(padded.corners_m()), 0.9 * 0.5 + 0.5 * 0.4, 1e-12);
  EXPECT_FALSE(holds(padded.corners_m(), {0.5, 0.5}));
}

TEST(Footprint, DentThatClosesIsFilled) {
  // Two prongs with a gap of 0.1 m.
  const auto fork = Footprint::make(
      {{-0.4, -0.3}, {0.5, -0.3}, {0.5, -0.05}, {0, -0.05}, {0, 0.05}, {0.5, 0.05}, {0.5, 0.3}, {-0.4, 0.3}});
  ASSERT_TRUE(fork);
  EXPECT_FALSE(holds(fork->corners_m(), {0.3, 0}));
  EXPECT_FALSE(holds(fork->padded(0.03).corners_m(), {0.3, 0}));
  const auto filled = fork->padded(0.06);
  EXPECT_TRUE(holds(filled.corners_m(), {0.3, 0}));
  EXPECT_NEAR(area_of(filled.corners_m()), 1.02 * 0.72, 1e-9);
}

TEST(Footprint, SharpCornersAreCutOffAtTwiceTheMargin) {
  const auto needle = Footprint::make({{-0.1, -0.1}, {1, 0}, {-0.1, 0.1}}).value();
  const auto padded = needle.padded(0.1);
  double farthest = 0;
  for (const auto& corner : padded.corners_m()) farthest = std::max(farthest, corner.x());
  EXPECT_NEAR(farthest, 1.2, 1e-9);
}

TEST(Footprint, PaddingKeepsEveryPointWithinTheMargin) {
  Rng rng(3);
  for (int round = 0; round < 300; ++round) {
    const auto footprint = Footprint::make(random_star(rng)).value();
    const double margin_m = rng.uniform(0.001, 0.15);
    const auto padded = footprint.padded(margin_m);
    ASSERT_TRUE(Footprint::make(padded.corners_m()) || padded.corners_m().size() > 100) << "round " << round;
    for (int i = 0; i < 100; ++i) {
      const double angle = rng.uniform(0, kTwoPi);
      const auto& a = footprint.corners_m()[static_cast<std::size_t>(
          rng.integer(0, static_cast<int>(footprint.corners_m().size()) - 1))];
      const auto& b = footprint.corners_m()[static_cast<std::size_t>(i) % footprint.corners_m().size()];
      Vector2d inside = a + rng.uniform(0, 1) * (b - a);
      if (!holds(footprint.corners_m(), inside)) continue;
      inside += rng.uniform(0, 0.999 * margin_m) * Vector2d(std::cos(angle), std::sin(angle));
      EXPECT_TRUE(holds(padded.corners_m(), inside)) << "round " << round;
    }
  }
}

TEST(Footprint, ShrinkingStaysInsideAndValid) {
  Rng rng(4);
  for (int round = 0; round < 300; ++round) {
    const auto footprint = Footprint::make(random_star(rng)).value();
    const double margin_m = rng.uniform(0.001, 0.5);
    const auto shrunk = footprint.padded(-margin_m);
    ASSERT_TRUE(Footprint::make(shrunk.corners_m()) || shrunk.corners_m().size() > 100) << "round " << round;
    EXPECT_LE(area_of(shrunk.corners_m()), area_of(footprint.corners_m()) + 1e-9);
    for (const auto& corner : shrunk.corners_m())
      EXPECT_TRUE(holds(footprint.corners_m(), corner * (1 - 1e-9))) << "round " << round;
  }
}

TEST(Footprint, ShrinkingStopsBeforeNothingIsLeft) {
  const auto shrunk = Footprint::make(kSquare)->padded(-1);
  EXPECT_GT(area_of(shrunk.corners_m()), 0.99e-4);
  EXPECT_LT(area_of(shrunk.corners_m()), 2e-4);
}

TEST(Footprint, ExtendedHoldsArms) {
  const auto extended = Footprint::make(kSquare)->extended(
      {{0.9, 0.1}, {0.1, 0}, {std::numeric_limits<double>::infinity(), 0}});
  EXPECT_EQ(extended.corners_m().size(), 5U);
  EXPECT_NEAR(extended.circumscribed_radius_m(), std::hypot(0.9, 0.1), 1e-12);
  EXPECT_NEAR(extended.inscribed_radius_m(), 0.4, 1e-12);
}

TEST(Footprint, ConvexPartsMakeUpTheArea) {
  Rng rng(5);
  for (int round = 0; round < 500; ++round) {
    const auto footprint = Footprint::make(random_star(rng)).value();
    double area = 0;
    for (const auto& part : footprint.convex_parts_m()) {
      EXPECT_GT(area_of(part), 0);
      area += area_of(part);
    }
    EXPECT_NEAR(area, area_of(footprint.corners_m()), 1e-9) << "round " << round;
  }
}

}  // namespace
}  // namespace extperfc::navigate
