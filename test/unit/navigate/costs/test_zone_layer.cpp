// Zones: keep-out polygons and maps, speed zones, their file.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/zone_layer.hpp"
#include "extperfc/world/map_file.hpp"

#include "test/support/temporary_folder.hpp"
#include "test/unit/navigate/costs/polygon_oracle.hpp"

namespace extperfc::navigate {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

const std::vector<Vector2d> kL{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};

fs::path folder() {
  static const TemporaryFolder temporary;
  return temporary.path();
}

Result<Zones> zones_of(const std::string& text) {
  const fs::path file = folder() / "zones.yaml";
  std::ofstream(file) << text;
  return load_zones(file);
}

TEST(ZoneLayer, EveryOverlappedCellIsLethal) {
  Rng rng(1);
  for (int round = 0; round < 30; ++round) {
    CostGrid grid = make_cost_grid(60, 60, 0.1, {-3, -3}, kFreeCost);
    ZoneLayer layer;
    layer.match(grid);
    layer.set_zones({{{"L", kL}}, {}, {}});
    const Pose2 pose{rng.uniform(-2, 1), rng.uniform(-2, 1), rng.uniform(-kPi, kPi)};
    layer.set_pose(pose);
    EXPECT_FALSE(layer.take_changes(grid, 0).empty());
    EXPECT_TRUE(layer.take_changes(grid, 0).empty());
    layer.write(grid, grid.box());
    const auto placed = test::moved(kL, pose);
    for (int row = 0; row < grid.height; ++row)
      for (int column = 0; column < grid.width; ++column) {
        const double area_m2 = test::overlap_m2(grid, {column, row}, placed);
        if (area_m2 > 0 && area_m2 < 1e-6) continue;
        ASSERT_EQ(grid.at({column, row}) == kLethalCost, area_m2 > 0) << "round " << round;
      }
  }
}

TEST(ZoneLayer, PoseOfTheMapChangesOnlyWhatIsKeptOutOf) {
  const CostGrid grid = make_cost_grid(60, 60, 0.1, {-3, -3}, kFreeCost);
  ZoneLayer layer;
  layer.match(grid);
  (void)layer.take_changes(grid, 0);
  layer.set_pose({1, 0, 0.3});
  EXPECT_TRUE(layer.take_changes(grid, 0).empty());
  layer.set_zones({{{"L", kL}}, {}, {}});
  (void)layer.take_changes(grid, 0);
  layer.set_pose({1, 0, 0.3});
  EXPECT_TRUE(layer.take_changes(grid, 0).empty());
  layer.set_pose({1, 0, 0.31});
  EXPECT_FALSE(layer.take_changes(grid, 0).empty());
}

TEST(ZoneLayer, SmallestFactorOfOverlappingZones) {
  ZoneLayer layer;
  SpeedZone slow, slower;
  slow.corners_m = kL;
  slow.factor = 0.5;
  slower.corners_m = {{0, 0}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}};
  slower.factor = 0.2;
  layer.set_zones({{}, {}, {slow, slower}});
  EXPECT_EQ(layer.speed_factor_at({0.2, 0.2}), 0.2);
  EXPECT_EQ(layer.speed_factor_at({1.5, 0.5}), 0.5);
  EXPECT_EQ(layer.speed_factor_at({1.5, 1.5}), 1);
  layer.set_pose({10, 0, kPi / 2});
  EXPECT_EQ(layer.speed_factor_at({10 - 0.2, 0.2}), 0.2);
  EXPECT_EQ(layer.speed_factor_at({10 - 0.5, 1.5}), 0.5);
  EXPECT_EQ(layer.speed_factor_at({0.2, 0.2}), 1);
}

TEST(ZoneLayer, RefusesWhatIsNoZone) {
  ZoneLayer layer;
  EXPECT_THROW(layer.set_zones({{{"bow", {{0, 0}, {1, 1}, {1, 0}, {0, 1}}}}, {}, {}}), std::invalid_argument);
  SpeedZone stop;
  stop.corners_m = kL;
  stop.factor = 0;
  EXPECT_THROW(layer.set_zones({{}, {}, {stop}}), std::invalid_argument);
}

TEST(Zones, FileIsRead) {
  OccupancyGrid map;
  map.width = map.height = 4;
  map.cells.assign(16, 0);
  map.cells[5] = 100;
  ASSERT_TRUE(save_map(map, folder() / "lift"));
  const auto zones = zones_of(R"(
keep_out:
  - {name: stairs, polygon: [[0, 0], [1, 0], [1, 2]]}
  - {name: lift, map: lift.yaml}
speed:
  - {name: corridor, factor: 0.5, polygon: [[5, 2], [9, 2], [9, 0], [5, 0]]}
)");
  ASSERT_TRUE(zones) << zones.error().message;
  ASSERT_EQ(zones->keep_out.size(), 1U);
  EXPECT_EQ(zones->keep_out[0].name, "stairs");
  ASSERT_EQ(zones->keep_out_maps.size(), 1U);
  ASSERT_EQ(zones->speed.size(), 1U);
  EXPECT_EQ(zones->speed[0].factor, 0.5);
  CostGrid grid = make_cost_grid(6, 6, 0.05, {0, 0}, 9);
  ZoneLayer layer;
  layer.match(grid);
  layer.set_zones({{}, {zones->keep_out_maps[0], zones->keep_out_maps[0]}, {}});
  layer.write(grid, grid.box());
  EXPECT_EQ(std::count(grid.cells.begin(), grid.cells.end(), kLethalCost), 1);
  EXPECT_EQ(grid.at({1, 1}), kLethalCost);
  EXPECT_EQ(grid.at({0, 0}), 9);
}

TEST(Zones, EveryProblemIsNamedWithItsLine) {
  const auto zones = zones_of(R"(keep_out:
  - {name: bow, polygon: [[0, 0], [1, 1], [1, 0], [0, 1]]}
  - {name: flat, polygon: [[0, 0], [1, x], [1, 0]]}
  - {polygon: [[0, 0], [1, 0]]}
  - {name: both, map: none.yaml, polygon: [[0, 0], [1, 0], [1, 2]]}
speed:
  - {name: fast, factor: 1.5, polygon: [[0, 0], [1, 0], [1, 2]]}
sped: []
)");
  ASSERT_FALSE(zones);
  const std::string& message = zones.error().message;
  for (const char* part :
       {"zones.yaml:2: keep_out[0].polygon: its edges", "zones.yaml:3: keep_out[1].polygon[1][1]",
        "zones.yaml:4: keep_out[2].name", "zones.yaml:4: keep_out[2].polygon: must have at least 3",
        "zones.yaml:5: keep_out[3].polygon: a zone has", "keep_out[3].map", "zones.yaml:7: speed[0].factor",
        "unknown key \"sped\""})
    EXPECT_NE(message.find(part), std::string::npos) << part << "\n" << message;
  EXPECT_FALSE(load_zones(folder() / "absent.yaml"));
  EXPECT_TRUE(zones_of("{}"));
}

}  // namespace
}  // namespace extperfc::navigate
