#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "ros/simulate/sensor_faults.hpp"

namespace extperfc::ros_simulate {
namespace {

using simulate::CameraImages;
using simulate::Fault;
using simulate::FaultKind;
using simulate::LidarPoint;
using Faults = std::vector<Fault>;

constexpr std::uint64_t kSeed = 7;

/// An image that is `value` everywhere.
CameraImages camera_images(std::uint8_t value) {
  constexpr std::size_t kPixels = 100 * 80;
  CameraImages images{100, 80, {}, {}, {}, {}};
  images.rgb.assign(3 * kPixels, value);
  images.depth_mm.assign(kPixels, 1000);
  images.true_depth_m.assign(kPixels, 1.0F);
  images.instance.assign(kPixels, 3);
  return images;
}

std::vector<LidarPoint> sweep() {
  std::vector<LidarPoint> points;
  for (int column = 0; column < 100; ++column)
    for (std::uint16_t ring = 0; ring < 16; ++ring) points.push_back({1, 2, 3, 50, ring, 0});
  return points;
}

/// Fraction of a hundred thousand moments at which `lost(time_s)` is true, and the five-sigma bound of a
/// fraction.
template <typename Lost>
double fraction_of(Lost&& lost) {
  constexpr int kMoments = 100000;
  int count = 0;
  for (int i = 0; i < kMoments; ++i) count += lost(i / 15.0) ? 1 : 0;
  return static_cast<double>(count) / kMoments;
}
double five_sigma(double fraction, double samples) {
  return 5 * std::sqrt(fraction * (1 - fraction) / samples);
}

TEST(CameraFaults, NoneLeavesTheImageAlone) {
  CameraFaults faults(kSeed);
  auto images = camera_images(10);
  EXPECT_EQ(faults.apply({}, 1.0, images), Fate::kDelivered);
  EXPECT_EQ(images.rgb, camera_images(10).rgb);
  EXPECT_EQ(images.depth_mm, camera_images(10).depth_mm);
  EXPECT_FALSE(faults.frozen({}));
}

TEST(CameraFaults, FreezeRepeatsItsFirstImage) {
  CameraFaults faults(kSeed);
  const Faults freeze{{FaultKind::kCameraFreeze, "", 1, 0}};
  auto first = camera_images(10);
  EXPECT_FALSE(faults.frozen(freeze)) << "its first image must be rendered";
  EXPECT_EQ(faults.apply(freeze, 1.0, first), Fate::kDelivered);
  EXPECT_TRUE(faults.frozen(freeze));
  auto second = camera_images(20);
  EXPECT_EQ(faults.apply(freeze, 2.0, second), Fate::kDelivered);
  EXPECT_EQ(second.rgb, camera_images(10).rgb);
  auto after = camera_images(30);
  EXPECT_FALSE(faults.frozen({}));
  EXPECT_EQ(faults.apply({}, 3.0, after), Fate::kDelivered);
  EXPECT_EQ(after.rgb, camera_images(30).rgb);
  auto again = camera_images(40);
  EXPECT_FALSE(faults.frozen(freeze)) << "a second freeze has an image of its own";
  EXPECT_EQ(faults.apply(freeze, 4.0, again), Fate::kDelivered);
  EXPECT_EQ(again.rgb, camera_images(40).rgb);
}

TEST(CameraFaults, DropLosesItsShare) {
  CameraFaults faults(kSeed);
  CameraImages images = camera_images(1);
  images.depth_mm.clear();
  for (const double fraction : {0.0, 0.3, 1.0}) {
    const Faults drop{{FaultKind::kCameraDrop, "", fraction, 0}};
    const auto lost = [&](double time_s) { return faults.apply(drop, time_s, images) == Fate::kLost; };
    EXPECT_NEAR(fraction_of(lost), fraction, five_sigma(fraction, 1e5) + 1e-12);
  }
}

TEST(CameraFaults, DropIsTheSameInEveryRunButNotForEverySeed) {
  CameraFaults one(kSeed);
  CameraFaults same(kSeed);
  CameraFaults other(kSeed + 1);
  auto images = camera_images(1);
  const Faults drop{{FaultKind::kCameraDrop, "", 0.5, 0}};
  int differ = 0;
  for (int i = 0; i < 200; ++i) {
    const Fate fate = one.apply(drop, i / 15.0, images);
    ASSERT_EQ(fate, same.apply(drop, i / 15.0, images));
    differ += fate != other.apply(drop, i / 15.0, images) ? 1 : 0;
  }
  EXPECT_GT(differ, 50);
}

TEST(CameraFaults, NanLosesItsShareOfTheDepthOnly) {
  CameraFaults faults(kSeed);
  auto images = camera_images(10);
  EXPECT_EQ(faults.apply({{FaultKind::kCameraNan, "", 0.25, 0}}, 1.0, images), Fate::kDelivered);
  const auto lost = std::count(images.depth_mm.begin(), images.depth_mm.end(), 0);
  const auto pixels = static_cast<double>(images.depth_mm.size());
  EXPECT_NEAR(static_cast<double>(lost) / pixels, 0.25, five_sigma(0.25, pixels));
  EXPECT_EQ(images.rgb, camera_images(10).rgb);
  auto later = camera_images(10);
  EXPECT_EQ(faults.apply({{FaultKind::kCameraNan, "", 0.25, 0}}, 2.0, later), Fate::kDelivered);
  EXPECT_NE(images.depth_mm, later.depth_mm) << "other pixels each time";
}

TEST(CameraFaults, NanDoesNotEatTheFrozenImage) {
  CameraFaults faults(kSeed);
  const Faults both{{FaultKind::kCameraFreeze, "", 1, 0}, {FaultKind::kCameraNan, "", 0.5, 0}};
  CameraImages images = camera_images(10);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(faults.apply(both, i, images), Fate::kDelivered);
  const auto lost = std::count(images.depth_mm.begin(), images.depth_mm.end(), 0);
  EXPECT_NEAR(static_cast<double>(lost) / 8000.0, 0.5, five_sigma(0.5, 8000));
}

std::set<int> rings_left(const std::string& target) {
  const LidarFaults faults(kSeed);
  auto points = sweep();
  EXPECT_EQ(faults.apply({{FaultKind::kLidarRings, target, 1, 0}}, 1.0, points), Fate::kDelivered);
  std::set<int> rings;
  for (const auto& point : points) rings.insert(point.ring);
  EXPECT_EQ(points.size(), 100 * rings.size()) << "the others are whole";
  return rings;
}

TEST(LidarFaults, RingsAreMissing) {
  EXPECT_EQ(rings_left("3,7"), (std::set<int>{0, 1, 2, 4, 5, 6, 8, 9, 10, 11, 12, 13, 14, 15}));
  EXPECT_EQ(rings_left("0, 15").size(), 14U);
  EXPECT_EQ(rings_left("").size(), 0U) << "no target: all";
  EXPECT_EQ(rings_left("all").size(), 0U);
}

TEST(LidarFaults, SeveralRingFaultsAddUp) {
  const LidarFaults faults(kSeed);
  auto points = sweep();
  const Faults two{{FaultKind::kLidarRings, "1", 1, 0}, {FaultKind::kLidarRings, "2", 1, 0}};
  EXPECT_EQ(faults.apply(two, 1.0, points), Fate::kDelivered);
  EXPECT_EQ(points.size(), 1400U);
}

TEST(LidarFaults, DropLosesItsShareOfSweeps) {
  const LidarFaults faults(kSeed);
  std::vector<LidarPoint> points;
  const Faults drop{{FaultKind::kLidarDrop, "", 0.2, 0}};
  const auto lost = [&](double time_s) { return faults.apply(drop, time_s, points) == Fate::kLost; };
  EXPECT_NEAR(fraction_of(lost), 0.2, five_sigma(0.2, 1e5));
}

TEST(LidarFaults, FaultsOfTheCameraDoNotTouchTheLidar) {
  const LidarFaults faults(kSeed);
  auto points = sweep();
  const Faults all{{FaultKind::kCameraDrop, "", 1, 0}, {FaultKind::kCameraNan, "", 1, 0}};
  EXPECT_EQ(faults.apply(all, 1.0, points), Fate::kDelivered);
  EXPECT_EQ(points.size(), sweep().size());
}

}  // namespace
}  // namespace extperfc::ros_simulate
