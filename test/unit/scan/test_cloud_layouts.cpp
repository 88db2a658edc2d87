// Clouds as drivers lay them out: byte orders, number types, padding; and damaged ones.
#include <gtest/gtest.h>

#include "test/unit/scan/cloud_builder.hpp"

namespace extperfc::scan {
namespace {

const std::vector<TestPoint> kPoints{
    {3, 0, 0.5F, 10, 1}, {0, 4, 0.5F, 20, 2}, {-5, 0, 0.5F, 30, 3}, {0, -6, 0.5F, 40, 4}};

void expect_four_points(const Outcome& outcome, bool with_intensity = true) {
  const auto& scan = outcome.scan;
  EXPECT_EQ(hits(scan), 4U);
  EXPECT_FLOAT_EQ(scan.ranges[ray_at(scan, 0)], 3.0F);
  EXPECT_FLOAT_EQ(scan.ranges[ray_at(scan, M_PI / 2)], 4.0F);
  EXPECT_FLOAT_EQ(scan.ranges[0], 5.0F);
  EXPECT_FLOAT_EQ(scan.ranges[ray_at(scan, -M_PI / 2)], 6.0F);
  if (with_intensity) {
    EXPECT_FLOAT_EQ(scan.intensities[ray_at(scan, M_PI / 2)], 20.0F);
  }
}

TEST(CloudLayouts, LittleAndBigEndian) {
  for (const bool big_endian : {false, true}) {
    const CloudBuilder cloud(kPoints, big_endian);
    auto params = open_params();
    expect_four_points(run(params, cloud.view()));
    params.rings = *parse_rings("2-3");
    EXPECT_EQ(run(params, cloud.view()).statistics.used, 2U) << "ring numbers have a byte order too";
  }
}

TEST(CloudLayouts, OrganisedWithPaddedRows) {
  // Two rows of two points; the rows are padded, and the last row's padding is missing.
  const CloudBuilder plain(kPoints);
  const auto view = plain.view();
  constexpr std::size_t kRow = 2 * CloudBuilder::kStep;
  std::vector<std::uint8_t> padded(view.data, view.data + kRow);
  padded.insert(padded.end(), 10, 0xff);
  padded.insert(padded.end(), view.data + kRow, view.data + 2 * kRow);
  auto organised = view;
  organised.data = padded.data();
  organised.bytes = padded.size();
  organised.width = 2;
  organised.height = 2;
  organised.row_step = kRow + 10;
  expect_four_points(run(open_params(), organised));
}

TEST(CloudLayouts, DoublesAndWholeNumbers) {
  struct Packed {
    double x, y;
    std::int32_t z;
    std::uint8_t intensity, ring;
  };
  std::vector<Packed> packed;
  for (const auto& p : kPoints)
    packed.push_back(
        {p.x, p.y, 1, static_cast<std::uint8_t>(p.intensity), static_cast<std::uint8_t>(p.ring)});
  auto view = packed_view(packed);
  view.x = {offsetof(Packed, x), NumberType::kFloat64};
  view.y = {offsetof(Packed, y), NumberType::kFloat64};
  view.z = {offsetof(Packed, z), NumberType::kInt32};
  view.intensity = CloudField{offsetof(Packed, intensity), NumberType::kUint8};
  view.ring = CloudField{offsetof(Packed, ring), NumberType::kUint8};
  expect_four_points(run(open_params(), view));
  auto params = open_params();
  params.rings = *parse_rings("4");
  EXPECT_EQ(run(params, view).statistics.used, 1U);
}

TEST(CloudLayouts, WithoutIntensity) {
  const CloudBuilder cloud(kPoints);
  auto view = cloud.view();
  view.intensity.reset();
  const auto outcome = run(open_params(), view);
  expect_four_points(outcome, false);
  EXPECT_TRUE(outcome.scan.intensities.empty());
  EXPECT_TRUE(outcome.statistics.intensity_missing);
}

TEST(CloudLayouts, RingsWithoutRingField) {
  const CloudBuilder cloud(kPoints);
  auto view = cloud.view();
  view.ring.reset();
  auto params = open_params();
  EXPECT_NO_THROW(run(params, view));
  params.rings = *parse_rings("4");
  auto converter = CloudToScan::make(params);
  PlanarScans scans;
  const auto refused = converter->convert(view, {{0, Pose::Identity()}}, {}, scans);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kNotFound);
  EXPECT_NE(refused.error().message.find("ring"), std::string::npos) << refused.error().message;
}

TEST(CloudLayouts, PointsAlone) {
  for (const bool big_endian : {false, true}) {
    const CloudBuilder cloud(kPoints, big_endian);
    const auto points = points_of(cloud.view());
    ASSERT_TRUE(points);
    ASSERT_EQ(points->size(), kPoints.size());
    for (std::size_t i = 0; i < kPoints.size(); ++i)
      EXPECT_EQ((*points)[i], Eigen::Vector3f(kPoints[i].x, kPoints[i].y, kPoints[i].z));
  }
  EXPECT_TRUE(points_of(CloudView{})->empty());
}

TEST(CloudLayouts, DamagedOnesAreRefused) {
  const CloudBuilder cloud(kPoints);
  const auto good = cloud.view();
  ASSERT_TRUE(validate(good));
  std::vector<CloudView> damaged(10, good);
  damaged[0].bytes -= 1;
  damaged[1].width += 1;
  damaged[2].height = 2;
  damaged[3].point_step = 0;
  damaged[4].x.offset = CloudBuilder::kStep - 3;
  damaged[5].ring->offset = std::numeric_limits<std::size_t>::max() - 1;
  damaged[6].row_step = 1;
  damaged[7].height = std::numeric_limits<std::size_t>::max() / 2;
  damaged[8].width = std::numeric_limits<std::size_t>::max() / 4;
  damaged[9].time->field.offset = CloudBuilder::kStep - 3;
  for (std::size_t i = 0; i < damaged.size(); ++i) {
    const auto refused = validate(damaged[i]);
    ASSERT_FALSE(refused) << i;
    EXPECT_EQ(refused.error().code, ErrorCode::kCorrupt);
    EXPECT_FALSE(points_of(damaged[i])) << i;
    auto converter = CloudToScan::make(open_params());
    PlanarScans scans;
    EXPECT_FALSE(converter->convert(damaged[i], {{0, Pose::Identity()}}, {}, scans)) << i;
  }
}

}  // namespace
}  // namespace extperfc::scan
