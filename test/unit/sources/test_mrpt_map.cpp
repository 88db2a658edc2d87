// Our files read by MRPT itself, and MRPT's by us.
#include <cmath>
#include <fstream>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>

#include "extperfc/sources/mrpt_map.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::sources {
namespace {

namespace fs = std::filesystem;
using mrpt::maps::COccupancyGridMap2D;
using mrpt::obs::CObservation2DRangeScan;

constexpr char kExample[] = "/usr/share/mrpt/datasets/2006-MalagaCampus.gridmap.gz";

/// 7 x 5 cells of 0.1 m from (-0.3, 0.2) on: no two rows or columns are alike.
OccupancyGrid small_map() {
  OccupancyGrid map;
  map.width = 7;
  map.height = 5;
  map.resolution_m = 0.1;
  map.origin = {-0.3, 0.2, 0};
  map.cells.assign(35, OccupancyGrid::kUnknown);
  for (std::size_t i = 0; i < 15; ++i) map.cells[i] = OccupancyGrid::kFree;
  for (const std::size_t i : {3, 9, 17, 30}) map.cells[i] = OccupancyGrid::kOccupied;
  return map;
}

COccupancyGridMap2D read_by_mrpt(const fs::path& file) {
  mrpt::io::CFileGZInputStream stream(file.string());
  COccupancyGridMap2D grid;
  mrpt::serialization::archiveFrom(stream) >> grid;
  return grid;
}

class GridmapFile : public testing::TestWithParam<const char*> {
 protected:
  TemporaryFolder folder_;
};

TEST_P(GridmapFile, IsReadByMrptWithEqualCells) {
  const auto map = small_map();
  const auto file = folder_.path() / GetParam();
  const auto saved = save_gridmap(map, file);
  ASSERT_TRUE(saved) << saved.error().message;
  const auto grid = read_by_mrpt(file);
  ASSERT_EQ(grid.getSizeX(), map.width);
  ASSERT_EQ(grid.getSizeY(), map.height);
  EXPECT_NEAR(grid.getXMin(), -0.3, 1e-6);
  EXPECT_NEAR(grid.getYMin(), 0.2, 1e-6);
  EXPECT_NEAR(grid.getResolution(), 0.1, 1e-6);
  for (std::size_t row = 0; row < map.height; ++row)
    for (std::size_t column = 0; column < map.width; ++column) {
      const auto middle = map.middle_of({column, row});
      const double free =
          static_cast<double>(grid.getPos(static_cast<float>(middle.x), static_cast<float>(middle.y)));
      const auto cell = map.at(column, row);
      EXPECT_NEAR(free, cell < 0 ? 0.5 : 1 - cell / 100.0, 1e-3) << column << " " << row;
    }
}

TEST_P(GridmapFile, ComesBackAsItWas) {
  const auto map = small_map();
  const auto file = folder_.path() / GetParam();
  ASSERT_TRUE(save_gridmap(map, file));
  const auto read = load_gridmap(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->width, map.width);
  EXPECT_EQ(read->height, map.height);
  EXPECT_EQ(read->resolution_m, map.resolution_m);
  EXPECT_EQ(read->origin.x, map.origin.x);
  EXPECT_EQ(read->origin.y, map.origin.y);
  EXPECT_EQ(read->cells, map.cells);
}

INSTANTIATE_TEST_SUITE_P(All, GridmapFile, testing::Values("map.gridmap", "map.gridmap.gz"),
                         [](const auto& test) {
                           return std::string(test.param).size() > 11 ? "packed" : "plain";
                         });

TEST(Gridmap, OnlyTheNameDecidesWhetherItIsPacked) {
  const TemporaryFolder folder;
  ASSERT_TRUE(save_gridmap(small_map(), folder.path() / "a.gridmap"));
  ASSERT_TRUE(save_gridmap(small_map(), folder.path() / "a.gridmap.gz"));
  std::ifstream plain(folder.path() / "a.gridmap", std::ios::binary);
  std::ifstream packed(folder.path() / "a.gridmap.gz", std::ios::binary);
  EXPECT_NE(plain.get(), 0x1f);
  EXPECT_EQ(packed.get(), 0x1f);
  EXPECT_TRUE(names_gridmap("a.gridmap") && names_gridmap("x/a.gridmap.gz"));
  EXPECT_FALSE(names_gridmap("a.yaml") || names_gridmap("gridmap") || names_gridmap("a.simplemap.gz"));
}

/// The step of a byte's logarithm of odds is the largest in the middle: 1/16 of odds 1, that is 1.6 percent
/// from value to value, so rounding moves a probability by 0.8 percent, and the whole percent by another
/// half.
TEST(Gridmap, ProbabilitiesMoveByAPercentAtMost) {
  const TemporaryFolder folder;
  OccupancyGrid map;
  map.width = 101;
  map.height = 1;
  for (int percent = 0; percent <= 100; ++percent) map.cells.push_back(static_cast<std::int8_t>(percent));
  ASSERT_TRUE(save_gridmap(map, folder.path() / "probabilities.gridmap"));
  const auto read = load_gridmap(folder.path() / "probabilities.gridmap");
  ASSERT_TRUE(read);
  for (int percent = 0; percent <= 100; ++percent) {
    const int found = read->cells[static_cast<std::size_t>(percent)];
    if (percent == 50)
      EXPECT_EQ(found, OccupancyGrid::kUnknown);
    else
      EXPECT_NEAR(found, percent, 1) << percent;
  }
}

TEST(Gridmap, ReadsAMapOfMrpts) {
  if (!fs::exists(kExample)) GTEST_SKIP() << "the package mrpt-common is not installed";
  const auto grid = read_by_mrpt(kExample);
  const auto map = load_gridmap(kExample);
  ASSERT_TRUE(map) << map.error().message;
  ASSERT_EQ(map->width, grid.getSizeX());
  ASSERT_EQ(map->height, grid.getSizeY());
  EXPECT_NEAR(map->resolution_m, grid.getResolution(), 1e-6);
  EXPECT_NEAR(map->origin.x, grid.getXMin(), 1e-5);
  std::size_t occupied = 0;
  for (std::size_t row = 0; row < map->height; ++row)
    for (std::size_t column = 0; column < map->width; ++column) {
      const double free = static_cast<double>(grid.getCell(static_cast<int>(column), static_cast<int>(row)));
      const int cell = map->at(column, row);
      occupied += cell > 50 ? 1U : 0U;
      if (cell < 0)
        ASSERT_NEAR(free, 0.5, 1e-6);
      else
        ASSERT_NEAR(cell, 100 * (1 - free), 0.5 + 1e-4);
    }
  EXPECT_GT(occupied, 1000U);
}

TEST(Gridmap, WhatMrptCannotKeepIsRefused) {
  const TemporaryFolder folder;
  const auto error_of = [&](const auto& change) {
    auto map = small_map();
    change(map);
    const auto saved = save_gridmap(map, folder.path() / "bad.gridmap");
    return saved ? std::string() : saved.error().message;
  };
  EXPECT_NE(error_of([](auto& map) { map.origin.yaw = 0.1; }).find("cannot be rotated"), std::string::npos);
  EXPECT_NE(error_of([](auto& map) { map.origin.x = -0.33; }).find("multiple of its resolution"),
            std::string::npos);
  EXPECT_NE(error_of([](auto& map) { map.cells.pop_back(); }).find("their number does not match its size"),
            std::string::npos);
  EXPECT_NE(error_of([](auto& map) { map.resolution_m = 0; }).find("resolution"), std::string::npos);
  EXPECT_TRUE(fs::is_empty(folder.path()));
  const auto nowhere = save_gridmap(small_map(), folder.path() / "none" / "a.gridmap");
  ASSERT_FALSE(nowhere);
  EXPECT_NE(nowhere.error().message.find("cannot write"), std::string::npos);
}

TEST(Gridmap, WhatIsNoneIsNamed) {
  const TemporaryFolder folder;
  const auto error_of = [](const fs::path& file) {
    const auto map = load_gridmap(file);
    return map ? std::string() : map.error().message;
  };
  EXPECT_EQ(error_of(folder.path() / "absent.gridmap").rfind("cannot read the map", 0), 0U);
  const auto whole = folder.path() / "whole.gridmap";
  ASSERT_TRUE(save_gridmap(small_map(), whole));
  std::string bytes;
  {
    std::ifstream in(whole, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  }
  for (std::size_t size = 0; size < bytes.size(); size += 7) {
    const auto cut = folder.path() / "cut.gridmap";
    std::ofstream(cut, std::ios::binary) << bytes.substr(0, size);
    EXPECT_NE(error_of(cut).find("cut.gridmap"), std::string::npos) << size << " of " << bytes.size();
  }
  const auto other = folder.path() / "other.gridmap";
  {
    mrpt::io::CFileGZOutputStream stream(other.string());
    mrpt::serialization::archiveFrom(stream) << mrpt::maps::CSimpleMap();
  }
  EXPECT_NE(error_of(other).find("no grid map of MRPT"), std::string::npos);
}

/// Five rays from -90 to 90 degrees: two returns, one that met nothing, one NaN, one too near.
LaserScan five_rays() {
  LaserScan scan;
  scan.stamp_s = 1234.5;
  scan.angle_min = -M_PI / 2;
  scan.angle_increment = M_PI / 4;
  scan.range_min = 0.1;
  scan.range_max = 10;
  scan.base_T_sensor = {0.2, 0, 0.5};
  scan.ranges = {1.0F, 2.0F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN(),
                 0.05F};
  return scan;
}

TEST(Simplemap, IsReadByMrpt) {
  const TemporaryFolder folder;
  for (const auto* name : {"map.simplemap", "map.simplemap.gz"}) {
    const auto file = folder.path() / name;
    auto rotated =
        five_rays();  // a scanner whose rays do not lie evenly about its axis, and rotate the other way
    rotated.angle_min = 1.0;
    rotated.angle_increment = -0.1;
    const auto saved = save_simplemap({{{1, 2, 0.3}, five_rays()}, {{-1, 0, 3}, rotated}}, file);
    ASSERT_TRUE(saved) << saved.error().message;
    mrpt::maps::CSimpleMap map;
    ASSERT_TRUE(map.loadFromFile(file.string()));
    ASSERT_EQ(map.size(), 2U);
    const auto [pose, frame] = map.get(0);
    const auto mean = pose->getMeanVal();
    EXPECT_NEAR(mean.x(), 1, 1e-9);
    EXPECT_NEAR(mean.y(), 2, 1e-9);
    EXPECT_NEAR(mean.yaw(), 0.3, 1e-9);
    const auto scan = frame->getObservationByClass<CObservation2DRangeScan>();
    ASSERT_TRUE(scan);
    EXPECT_NEAR(mrpt::Clock::toDouble(scan->timestamp), 1234.5, 1e-6);
    ASSERT_EQ(scan->getScanSize(), 5U);
    const bool valid[] = {true, true, false, false, false};
    const float range[] = {1, 2, 10, 0, 0};
    for (std::size_t i = 0; i < 5; ++i) {
      EXPECT_EQ(scan->getScanRangeValidity(i), valid[i]) << i;
      EXPECT_EQ(scan->getScanRange(i), range[i]) << i;
    }
    EXPECT_NEAR(scan->sensorPose.yaw(), 0.5, 1e-6);
    const auto other = std::get<1>(map.get(1))->getObservationByClass<CObservation2DRangeScan>();
    EXPECT_NEAR(other->sensorPose.yaw(), 0.5 + 0.8, 1e-6) << "the middle of 1.0 to 0.6";
    EXPECT_NEAR(other->aperture, 0.4, 1e-6);
    EXPECT_FALSE(other->rightToLeft);
  }
}

/// MRPT draws a grid of the scans; where their rays end it is occupied.
TEST(Simplemap, MrptDrawsWhatTheScansSaw) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "map.simplemap";
  LaserScan wall;  // a wall at x = 2.05: in the middle of a cell
  wall.angle_min = -0.7;
  wall.angle_increment = 0.01;
  wall.range_max = 10;
  for (int i = 0; i <= 140; ++i)
    wall.ranges.push_back(static_cast<float>(2.05 / std::cos(wall.angle_min + 0.01 * i)));
  ASSERT_TRUE(save_simplemap({{{1, 0, M_PI / 2}, wall}}, file));  // so it lies at y = 2.05
  mrpt::maps::CSimpleMap map;
  ASSERT_TRUE(map.loadFromFile(file.string()));
  COccupancyGridMap2D grid(-5, 5, -5, 5, 0.1F);
  for (int i = 0; i < 5; ++i) grid.loadFromSimpleMap(map);
  EXPECT_LT(grid.getPos(1.0F, 2.05F), 0.5F) << "the wall";
  EXPECT_GT(grid.getPos(1.0F, 1.0F), 0.5F) << "free before it";
  EXPECT_NEAR(grid.getPos(1.0F, 3.0F), 0.5F, 1e-3F) << "unknown behind it";
}

TEST(Simplemap, WhatCannotBeIsRefused) {
  const TemporaryFolder folder;
  const auto none = save_simplemap({}, folder.path() / "a.simplemap");
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("no scans"), std::string::npos);
  auto bad = five_rays();
  bad.angle_increment = 0;
  const auto saved = save_simplemap({{{}, five_rays()}, {{}, bad}}, folder.path() / "a.simplemap");
  ASSERT_FALSE(saved);
  EXPECT_NE(saved.error().message.find("scan 1: "), std::string::npos) << saved.error().message;
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

}  // namespace
}  // namespace extperfc::sources
