// The mapper between the threads that the nodelet has, without ROS: one gives scans, one adds them, others
// take maps, poses and sessions meanwhile, and one puts another mapper in its place. The thread sanitizer
// looks on.
#include <algorithm>
#include <atomic>
#include <numeric>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "ros/mapping/scan_queue.hpp"
#include "ros/mapping/shared_mapper.hpp"
#include "test/support/temporary_folder.hpp"
#include "test/unit/mapping/mapper_drive.hpp"

namespace extperfc::mapping {
namespace {

constexpr std::size_t kMaxHeld = 64;

struct HeldMap {
  std::shared_ptr<const OccupancyGrid> map;
  long sum{0};  ///< of its cells when it was taken
};

long sum_of(const OccupancyGrid& map) {
  return std::accumulate(map.cells.begin(), map.cells.end(), 0L);
}

class MapperThreads : public testing::Test {
 protected:
  /// What the nodelet's worker does until the queue is closed.
  void work() {
    while (const auto scan = queue_.take()) {
      const auto update = mapper_.with(
          [&](Mapper& mapper) { return mapper.add(drive_.scans[*scan], drive_.odometry[*scan]); });
      EXPECT_TRUE(update) << update.error().message;
      ++added_;
    }
  }

  /// What its map thread does: the mapper is held while it hands the map over, not while the map is read.
  void take_maps(std::vector<HeldMap>& held) {
    while (!done_) {
      const auto map = mapper_.with([](Mapper& mapper) { return mapper.map(); });
      (void)mapper_.with([](Mapper& mapper) { return mapper.settled(); });
      const long sum = map ? sum_of(*map) : 0;
      if (map && held.size() < kMaxHeld) {
        held.push_back({map, sum});
        ++held_;
      }
      std::this_thread::yield();
    }
  }

  void ask() {
    while (!done_) {
      const auto [statistics, trajectory, particles] = mapper_.with([](const Mapper& mapper) {
        return std::make_tuple(mapper.statistics(), mapper.trajectory(), mapper.particles());
      });
      EXPECT_EQ(statistics.scans, trajectory.size());
      EXPECT_LE(particles.size(), 30U);
      std::this_thread::yield();
    }
  }

  /// Gives the scans in pieces, each when another map was taken, whatever fraction of the processors the
  /// threads have, and waits until all are added.
  void drive_to_the_end() {
    std::size_t awaited = 0;
    for (std::size_t i = 0; i < drive_.scans.size(); ++i) {
      EXPECT_FALSE(queue_.put(i));
      if (i % 10 != 9 || awaited == kMaxHeld) continue;
      awaited = std::min(held_ + 1, kMaxHeld);
      while (held_ < awaited) std::this_thread::yield();
    }
    while (added_ < drive_.scans.size()) std::this_thread::yield();
    done_ = true;
    queue_.close();
  }

  const MapperDrive drive_{record_room(3)};
  ros_mapping::SharedMapper mapper_{make_mapper()};
  ros_mapping::ScanQueue<std::size_t> queue_{1000};
  std::atomic<std::size_t> added_{0};
  std::atomic<std::size_t> held_{0};  ///< maps
  std::atomic<bool> done_{false};
};

TEST_F(MapperThreads, AMapThatSomebodyHoldsStaysAsItIs) {
  std::vector<HeldMap> held;
  std::thread worker([this] { work(); });
  std::thread maps([&] { take_maps(held); });
  std::thread asking([this] { ask(); });
  drive_to_the_end();
  worker.join();
  maps.join();
  asking.join();
  ASSERT_GT(held.size(), 2U);
  for (const auto& one : held) EXPECT_EQ(sum_of(*one.map), one.sum);
  // Who looked on had no influence on the path. (The map is another matter: key frames that a loop closure
  // moved by less than half a cell stay where they were drawn.)
  auto alone = make_mapper();
  (void)add_scans(alone, drive_, 0, drive_.scans.size());
  const auto expected = alone.trajectory();
  const auto found = mapper_.with([](const Mapper& mapper) { return mapper.trajectory(); });
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].pose.x, expected[i].pose.x) << i;
    EXPECT_EQ(found[i].pose.yaw, expected[i].pose.yaw) << i;
  }
}

TEST_F(MapperThreads, SearchesForLoopsWhileScansAreAdded) {
  std::vector<HeldMap> held;
  std::thread worker([this] { work(); });
  std::thread maps([&] { take_maps(held); });
  std::thread searching([this] {
    for (int part = 1; part < 4; ++part) {
      while (added_ < part * drive_.scans.size() / 4) std::this_thread::yield();
      auto search = mapper_.with([](const Mapper& mapper) { return mapper.search(); });
      search.run();
      EXPECT_TRUE(mapper_.with([&](Mapper& mapper) { return mapper.adopt(std::move(search)); }));
    }
  });
  drive_to_the_end();
  worker.join();
  maps.join();
  searching.join();
  const auto trajectory = mapper_.with([](const Mapper& mapper) { return mapper.trajectory(); });
  ASSERT_EQ(trajectory.size(), drive_.scans.size());
  for (std::size_t i = 0; i < trajectory.size(); i += 10)
    EXPECT_LT(drive_.error_m(trajectory[i].pose, i), 0.06) << i;
}

TEST_F(MapperThreads, SavesAndIsReplacedWhileScansAreAdded) {
  const TemporaryFolder folder;
  const auto session = folder.path() / "room.session";
  std::vector<HeldMap> held;
  std::thread worker([this] { work(); });
  std::thread maps([&] { take_maps(held); });
  std::thread services([&] {
    const std::size_t half = drive_.scans.size() / 2;
    while (added_ < half) std::this_thread::yield();
    const auto saved = mapper_.with([&](const Mapper& mapper) { return mapper.save(session); });
    EXPECT_TRUE(saved) << saved.error().message;
    auto loaded = Mapper::load(session, {});
    EXPECT_TRUE(loaded) << loaded.error().message;
    if (loaded) mapper_.replace(std::move(*loaded));
  });
  drive_to_the_end();
  services.join();
  worker.join();
  maps.join();
  for (const auto& one : held) EXPECT_EQ(sum_of(*one.map), one.sum) << "also of the mapper that is gone";
  const auto scans = mapper_.with([](const Mapper& mapper) { return mapper.statistics().scans; });
  EXPECT_GE(scans, drive_.scans.size() / 2);
  EXPECT_LE(scans, drive_.scans.size());
}

}  // namespace
}  // namespace extperfc::mapping
