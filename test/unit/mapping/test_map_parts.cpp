// Robots that are carried, sessions that are resumed elsewhere, and sessions that are merged.
#include <algorithm>
#include <filesystem>
#include <string>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "extperfc/mapping/mapper.hpp"

#include "mapping/map_parts.hpp"
#include "mapping/pose_graph.hpp"
#include "test/support/temporary_folder.hpp"
#include "test/unit/mapping/three_rooms.hpp"

namespace extperfc::mapping {
namespace {

/// As the programs do: scans, and a search whenever it may join parts.
std::size_t add_and_search(Mapper& mapper, const MapperDrive& drive, std::size_t first, std::size_t last) {
  std::size_t carried = 0;
  for (std::size_t i = first; i < last; ++i) {
    const auto update = mapper.add(drive.scans[i], drive.odometry[i]).value();
    carried += update.carried ? 1 : 0;
    if (mapper.wants_search()) mapper.optimize();
  }
  return carried;
}

double worst_m(const Mapper& mapper, const MapperDrive& drive, std::size_t first) {
  const Trajectory trajectory = mapper.trajectory();
  double worst = 0;
  for (std::size_t i = first; i < trajectory.size(); ++i)
    worst = std::max(worst, drive.error_m(trajectory[i].pose, i));
  return worst;
}

Eigen::Matrix3d about(double m, double rad) {
  return Eigen::Vector3d(m * m, m * m, rad * rad).asDiagonal();
}

TEST(CarriedRobot, IsNoticedAndFoundAgain) {
  const std::size_t before = planar_drive(kThroughAll, 0.12, 0.12).size();
  const MapperDrive drive = carried_between(kThroughAll, kBackFromThird, 1);
  Mapper mapper = make_mapper();
  EXPECT_EQ(add_and_search(mapper, drive, 0, before), 0U);
  EXPECT_EQ(add_and_search(mapper, drive, before, before + 12), 1U);
  EXPECT_EQ(mapper.statistics().parts, 2U);
  EXPECT_GT(mapper.statistics().position_sigma_m, 20) << "unknown where it is";
  EXPECT_EQ(add_and_search(mapper, drive, before + 12, drive.scans.size()), 0U);
  mapper.finish();
  EXPECT_EQ(mapper.statistics().carried, 1U);
  EXPECT_EQ(mapper.statistics().parts, 1U);
  EXPECT_LT(mapper.statistics().position_sigma_m, 0.2);
  EXPECT_LT(drive.error_m(mapper.trajectory()[before - 1].pose, before - 1), 0.06);
  EXPECT_LT(worst_m(mapper, drive, before), 0.1);
}

/// The wheels turned while it was in the air.
TEST(CarriedRobot, IsExpectedAfterAPause) {
  const std::size_t before = planar_drive(kThroughAll, 0.12, 0.12).size();
  MapperDrive drive = carried_between(kThroughAll, kBackFromThird, 3);
  const Pose2 moved = compose(drive.odometry[before - 1], {1, 0, 0});
  const Pose2 put_down = drive.odometry[before];
  for (std::size_t i = before; i < drive.scans.size(); ++i) {
    drive.odometry[i] = compose(moved, between(put_down, drive.odometry[i]));
    drive.scans[i].stamp_s = drive.scans[before - 1].stamp_s + 5 + 0.1 * static_cast<double>(i - before);
  }
  Mapper mapper = make_mapper();
  EXPECT_EQ(add_and_search(mapper, drive, 0, before), 0U);
  mapper.expect_elsewhere();
  EXPECT_EQ(add_and_search(mapper, drive, before, drive.scans.size()), 1U);
  mapper.finish();
  EXPECT_EQ(mapper.statistics().parts, 1U);
  EXPECT_LT(worst_m(mapper, drive, before), 0.1);
}

/// A lidar that was silent while the robot drove through a doorway: odometry is right, and too few places are
/// seen again to find the robot without it.
TEST(CarriedRobot, ThatWasNotCarriedStandsWhereOdometryHasIt) {
  const Corners before_door = {{2, 2}, {4, 3}, {6.5, 2}, {4, 4.5}, {2, 3}, {4, 3}, {6.5, 3}};
  const Corners after_door = {{9.2, 3}, {9.4, 3}, {8.6, 3.05}, {6.6, 3}, {4.2, 3}};
  MapperDrive drive = carried_between(before_door, after_door, 21);
  const std::size_t before = planar_drive(before_door, 0.12, 0.12).size();
  const Pose2 through_door = between(drive.truth[before - 1], drive.truth[before]);
  const Pose2 moved =
      compose(compose(drive.odometry[before - 1], through_door), inverse(drive.odometry[before]));
  for (std::size_t i = before; i < drive.odometry.size(); ++i)
    drive.odometry[i] = compose(moved, drive.odometry[i]);
  Mapper mapper = make_mapper();
  EXPECT_EQ(add_and_search(mapper, drive, 0, drive.scans.size()), 1U);
  mapper.finish();
  EXPECT_EQ(mapper.statistics().parts, 1U);
  EXPECT_LT(worst_m(mapper, drive, 0), 0.12);
}

TEST(CarriedRobot, StaysBesideAMapThatItDoesNotKnow) {
  const Corners first_room = {{2, 2}, {4, 3}, {6.5, 2}, {4, 4.5}, {2, 3}};
  const Corners third_room = {{18.5, 1.2}, {21.6, 1.4}, {21.6, 4.6}, {18.6, 4.2}, {18.5, 1.2}};
  const MapperDrive drive = carried_between(first_room, third_room, 4);
  const std::size_t before = planar_drive(first_room, 0.12, 0.12).size();
  Mapper mapper = make_mapper();
  EXPECT_EQ(add_and_search(mapper, drive, 0, drive.scans.size()), 1U);
  mapper.finish();
  EXPECT_EQ(mapper.statistics().parts, 2U);
  EXPECT_GT(mapper.statistics().position_sigma_m, 20);
  const Trajectory trajectory = mapper.trajectory();
  double right = -1e9;
  for (std::size_t i = 0; i < before; ++i) {
    EXPECT_LT(drive.error_m(trajectory[i].pose, i), 0.06);
    right = std::max(right, trajectory[i].pose.x);
  }
  const std::size_t from = before;
  for (std::size_t i = from; i < trajectory.size(); ++i) {
    EXPECT_GT(trajectory[i].pose.x, right + 12) << "beside it";
    const Pose2 off = between(between(drive.truth[from], drive.truth[i]),
                              between(trajectory[from].pose, trajectory[i].pose));
    EXPECT_LT(std::hypot(off.x, off.y), 0.08) << "the new part is a good map in itself";
  }
}

/// Wheels tell how the robot drove on while its lidar was silent; what it sees then may have nothing in
/// common with what it saw before.
TEST(SilentLidar, IsNoCarriedRobot) {
  const auto route = planar_drive(kThroughAll, 0.12, 0.12);
  const auto beyond = [&](double x_m) {
    return std::find_if(route.begin(), route.end(), [&](const Pose2& pose) { return pose.x > x_m; }) -
           route.begin();
  };
  for (const double door_m : {8.0, 16.0}) {
    SCOPED_TRACE(door_m);
    MapperDrive drive = drive_through(kThroughAll, 31);
    const auto cut = [&](auto& values) {
      values.erase(values.begin() + beyond(door_m - 1.5), values.begin() + beyond(door_m + 2));
    };
    cut(drive.scans);
    cut(drive.odometry);
    cut(drive.truth);
    Mapper mapper = make_mapper();
    EXPECT_EQ(add_and_search(mapper, drive, 0, drive.scans.size()), 0U);
    EXPECT_EQ(mapper.statistics().parts, 1U);
    mapper.finish();
    EXPECT_LT(worst_m(mapper, drive, 0), 0.2) << "half a degree over 20 m";
  }
}

class ResumedElsewhere : public testing::Test {
 protected:
  /// A session of all rooms, loaded again; the drive goes on in the third one.
  Mapper loaded() {
    Mapper mapper = make_mapper();
    (void)add_and_search(mapper, drive_, 0, before_);
    mapper.finish();
    EXPECT_TRUE(mapper.save(folder_.path() / "rooms.session"));
    return std::move(Mapper::load(folder_.path() / "rooms.session", {}).value());
  }

  void expect_found_by_places(Mapper& mapper) const {
    EXPECT_EQ(add_and_search(mapper, drive_, before_, drive_.scans.size()), 1U);
    mapper.finish();
    EXPECT_EQ(mapper.statistics().parts, 1U);
    EXPECT_LT(worst_m(mapper, drive_, before_), 0.1);
  }

  TemporaryFolder folder_;
  MapperDrive drive_ = carried_between(kThroughAll, kBackFromThird, 7);
  std::size_t before_ = planar_drive(kThroughAll, 0.12, 0.12).size();
};

TEST_F(ResumedElsewhere, WithAStartPose) {
  Mapper mapper = loaded();
  const Pose2 guess = compose(drive_.truth[before_], {0.35, -0.3, 0.25});
  ASSERT_TRUE(mapper.put_at(guess, about(0.5, 0.25)));
  EXPECT_EQ(add_and_search(mapper, drive_, before_, before_ + 3), 0U);
  EXPECT_EQ(mapper.statistics().parts, 1U);
  EXPECT_LT(drive_.error_m(mapper.pose(), before_ + 2), 0.15) << "at once";
  EXPECT_LT(mapper.statistics().position_sigma_m, 0.5);
  EXPECT_EQ(add_and_search(mapper, drive_, before_ + 3, drive_.scans.size()), 0U);
  mapper.finish();
  EXPECT_LT(worst_m(mapper, drive_, before_), 0.1);
  EXPECT_EQ(mapper.statistics().carried, 0U);
}

TEST_F(ResumedElsewhere, WithAWrongStartPose) {
  Mapper mapper = loaded();
  ASSERT_TRUE(mapper.put_at({3, 0.5, 0}, about(0.5, 0.25)));  // in the first room
  expect_found_by_places(mapper);
}

TEST_F(ResumedElsewhere, WithoutAStartPose) {
  Mapper mapper = loaded();
  expect_found_by_places(mapper);
}

TEST_F(ResumedElsewhere, StartPosesAreChecked) {
  Mapper mapper = loaded();
  EXPECT_FALSE(mapper.put_at({std::nan(""), 0, 0}, about(0.5, 0.2)));
  EXPECT_FALSE(mapper.put_at({0, 0, 0}, Eigen::Matrix3d::Zero()));
  EXPECT_FALSE(mapper.put_at({0, 0, 0}, -Eigen::Matrix3d::Identity()));
  EXPECT_FALSE(make_mapper().put_at({0, 0, 0}, about(0.5, 0.2))) << "there is no map yet";
}

class MergedSessions : public testing::Test {
 protected:
  std::filesystem::path session_of(const MapperDrive& drive, const std::string& name) {
    Mapper mapper = make_mapper();
    (void)add_and_search(mapper, drive, 0, drive.scans.size());
    mapper.finish();
    EXPECT_TRUE(mapper.save(folder_.path() / name));
    return folder_.path() / name;
  }

  TemporaryFolder folder_;
};

TEST_F(MergedSessions, AreJoinedByTheRoomThatBothShow) {
  const Corners first_two = {{2, 2}, {4, 3}, {8, 3}, {10, 2}, {14, 3.5}, {12, 3}, {8, 3}, {2, 3}};
  const Corners last_two = {{21.5, 4.5}, {18.5, 4}, {16, 3}, {12.5, 3.5},
                            {9.5, 2},    {13, 3},   {16, 3}, {18, 1.5}};
  const auto first = session_of(drive_through(first_two, 11), "first.session");
  const auto second = session_of(drive_through(last_two, 12), "second.session");
  const MapperDrive both = carried_between(first_two, last_two, 11);
  auto mapper = Mapper::load(first, {});
  ASSERT_TRUE(mapper);
  const auto merged = mapper->merge(second);
  ASSERT_TRUE(merged) << merged.error().message;
  EXPECT_TRUE(mapper->settled());
  EXPECT_EQ(mapper->statistics().parts, 1U);
  EXPECT_EQ(mapper->statistics().scans, both.scans.size());
  EXPECT_LT(worst_m(*mapper, both, 0), 0.1);
  ASSERT_TRUE(mapper->save(folder_.path() / "both.session"));
  const auto again = Mapper::load(folder_.path() / "both.session", {});
  ASSERT_TRUE(again);
  EXPECT_EQ(again->statistics().parts, 1U);
  EXPECT_LT(both.error_m(again->pose(), both.truth.size() - 1), 0.1)
      << "mapping goes on at the second one's end";
}

TEST_F(MergedSessions, OfDifferentBuildingsAreRefused) {
  const auto rooms = session_of(drive_through(kThroughAll, 13), "rooms.session");
  const auto other =
      session_of(record_drive(planar_loop(), planar_loop_route(0.25, 2.0), 14), "loop.session");
  auto mapper = Mapper::load(rooms, {});
  ASSERT_TRUE(mapper);
  const auto before = mapper->statistics();
  const auto merged = mapper->merge(other);
  ASSERT_FALSE(merged);
  EXPECT_EQ(merged.error().code, ErrorCode::kNotFound);
  EXPECT_NE(merged.error().message.find("loop.session"), std::string::npos);
  EXPECT_EQ(mapper->statistics().key_frames, before.key_frames);
  EXPECT_EQ(mapper->merge(folder_.path() / "none.session").error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(make_mapper().merge(rooms)) << "there is no map yet";
}

/// Nodes 0 to 2 in a row, then 3 to 5 after a step that tells nothing.
PoseGraph two_rows() {
  PoseGraph graph;
  for (int i = 0; i < 3; ++i) graph.add_node({1.0 * i, 0, 0});
  for (int i = 0; i < 3; ++i) graph.add_node({2.0 + i, 0.5, 0});
  const Eigen::Matrix3d information = 1e4 * Eigen::Matrix3d::Identity();
  for (const std::size_t i : {0U, 1U, 3U, 4U}) graph.add({i, i + 1, {1, 0, 0}, information, false, 0});
  graph.add(unknown_step(2, between(graph.poses()[2], graph.poses()[3])));
  return graph;
}

TEST(MapParts, AreJoinedByClosuresThatTheGraphAgreesWith) {
  PoseGraph graph = two_rows();
  EXPECT_EQ(parts_of(graph), (std::vector<std::size_t>{0, 0, 0, 1, 1, 1}));
  EXPECT_EQ(count_parts(graph), 2U);
  Constraint closure{1, 4, {0, 1, M_PI / 2}, 1e4 * Eigen::Matrix3d::Identity(), true, 0.9};
  graph.add(closure);
  EXPECT_EQ(count_parts(graph), 2U) << "contradicted";
  bring_together(graph, closure);
  EXPECT_EQ(count_parts(graph), 1U);
  EXPECT_NEAR(graph.poses()[4].x, 1, 1e-9);
  EXPECT_NEAR(graph.poses()[5].y, 2, 1e-9) << "as a whole, turned";
  for (const Constraint& constraint : graph.constraints())
    EXPECT_NEAR(graph.squared_error(constraint), 0, 1e-9);
}

TEST(MapParts, LieSideBySide) {
  PoseGraph graph = two_rows();
  set_parts_apart(graph);
  EXPECT_EQ(graph.poses()[2].x, 2) << "the first part stays";
  EXPECT_GT(graph.poses()[3].x, 12);
  EXPECT_NEAR(graph.poses()[5].x - graph.poses()[3].x, 2, 1e-9);
  EXPECT_GT(pose_beside(graph).x, graph.poses()[5].x + 10);
  for (const Constraint& constraint : graph.constraints())
    EXPECT_NEAR(graph.squared_error(constraint), 0, 1e-9);
}

}  // namespace
}  // namespace extperfc::mapping
