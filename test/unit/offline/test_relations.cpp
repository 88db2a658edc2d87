#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/offline/relations.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::offline {
namespace {

using ScanPoses = std::vector<std::optional<Pose2>>;

Pose2 random_pose(Rng& rng) {
  return {rng.uniform(-20, 20), rng.uniform(-20, 20), rng.uniform(-M_PI, M_PI)};
}

TEST(Relations, TheMetricByHand) {
  // Four poses on a line, one metre apart, all looking along x. The relations are off by 0.1 m ahead (error
  // 0.1 m), by a 3-4-5 triangle (0.5 m) with 2 degrees, and by a turn of -4 degrees alone.
  const ScanPoses poses = {Pose2{0, 0, 0}, Pose2{1, 0, 0}, Pose2{2, 0, 0}, Pose2{3, 0, 0}};
  const std::vector<Relation> relations = {
      {0, 1, {0.9, 0, 0}}, {0, 3, {3.3, 0.4, 2 * kDegree}}, {2, 1, {-1, 0, -4 * kDegree}}};
  const auto score = score_relations(relations, poses, {{}, 2});
  EXPECT_EQ(score.unmatched, 0U);
  ASSERT_EQ(score.errors.size(), 3U);
  EXPECT_NEAR(score.errors[0].translation_m, 0.1, 1e-12);
  EXPECT_NEAR(score.errors[1].translation_m, 0.5, 1e-12);
  EXPECT_NEAR(score.errors[1].rotation_deg, 2, 1e-9);
  EXPECT_NEAR(score.errors[2].translation_m, 0, 1e-12);
  EXPECT_NEAR(score.errors[2].rotation_deg, 4, 1e-9);

  EXPECT_EQ(score.all.relations, 3U);
  EXPECT_NEAR(score.all.translation_m.mean, 0.2, 1e-12);
  // Variance: ((0.1 - 0.2)^2 + (0.5 - 0.2)^2 + (0 - 0.2)^2) / 3 = 0.14 / 3.
  EXPECT_NEAR(score.all.translation_m.deviation, std::sqrt(0.14 / 3), 1e-12);
  EXPECT_NEAR(score.all.translation_m.squared_mean, (0.01 + 0.25) / 3, 1e-12);
  EXPECT_NEAR(score.all.translation_m.worst, 0.5, 1e-12);
  EXPECT_NEAR(score.all.rotation_deg.mean, 2, 1e-9);
  EXPECT_NEAR(score.all.rotation_deg.deviation, std::sqrt(8.0 / 3), 1e-9);
  EXPECT_NEAR(score.all.rotation_deg.squared_mean, 20.0 / 3, 1e-9);
  // Squares 0, 4 and 16 about 20/3.
  EXPECT_NEAR(score.all.rotation_deg.squared_deviation, std::sqrt((400.0 / 9 + 64.0 / 9 + 784.0 / 9) / 3),
              1e-9);

  EXPECT_EQ(score.loops.relations, 1U) << "only 0-3 spans more than two scans";
  EXPECT_NEAR(score.loops.translation_m.mean, 0.5, 1e-12);
  EXPECT_EQ(score.neighbours.relations, 2U);
  EXPECT_NEAR(score.neighbours.translation_m.mean, 0.05, 1e-12);
}

TEST(Relations, TrueRelationsScoreZeroWhereverTheTrajectoryStands) {
  Rng rng(7);
  for (int trial = 0; trial < 20; ++trial) {
    const Pose2 elsewhere = random_pose(rng);
    std::vector<Pose2> truth;
    ScanPoses poses;
    for (int i = 0; i < 30; ++i) {
      truth.push_back(random_pose(rng));
      poses.emplace_back(compose(elsewhere, truth.back()));
    }
    std::vector<Relation> relations;
    for (int i = 0; i < 50; ++i) {
      const auto from = static_cast<std::size_t>(rng.integer(0, 29));
      const auto to = static_cast<std::size_t>(rng.integer(0, 29));
      relations.push_back({from, to, between(truth[from], truth[to])});
    }
    const auto score = score_relations(relations, poses);
    EXPECT_LT(score.all.translation_m.worst, 1e-9) << "trial " << trial;
    EXPECT_LT(score.all.rotation_deg.worst, 1e-6) << "trial " << trial;
  }
}

TEST(Relations, AreBetweenScanners) {
  Rng rng(7);
  const Pose2 base_T_scanner{-0.04, 0.01, 0.3};
  ScanPoses poses;
  for (int i = 0; i < 20; ++i) poses.emplace_back(random_pose(rng));
  std::vector<Relation> relations;
  for (std::size_t i = 1; i < poses.size(); ++i)
    relations.push_back(
        {0, i, between(compose(*poses[0], base_T_scanner), compose(*poses[i], base_T_scanner))});
  EXPECT_LT(score_relations(relations, poses, {base_T_scanner}).all.translation_m.worst, 1e-9);
  EXPECT_GT(score_relations(relations, poses).all.translation_m.worst, 0.05);
}

TEST(Relations, ErrorsTakeTheShorterRotation) {
  const ScanPoses poses = {Pose2{0, 0, 0}, Pose2{0, 0, 179 * kDegree}};
  const auto score = score_relations({{0, 1, {0, 0, -179 * kDegree}}}, poses);
  EXPECT_NEAR(score.all.rotation_deg.mean, 2, 1e-9);
}

TEST(Relations, ScansWithoutPosesAreCounted) {
  const ScanPoses poses = {Pose2{0, 0, 0}, std::nullopt, Pose2{2, 0, 0}};
  const auto score = score_relations({{0, 1, {}}, {0, 2, {2, 0, 0}}, {0, 9, {}}, {7, 0, {}}}, poses);
  EXPECT_EQ(score.unmatched, 3U);
  ASSERT_EQ(score.errors.size(), 1U);
  EXPECT_EQ(score.errors[0].relation, 1U);
  EXPECT_EQ(score.loops.relations, 0U);
  EXPECT_EQ(score.loops.translation_m.mean, 0);
}

TEST(Relations, TheWorstComeFirst) {
  RelationsScore score;
  for (const double error : {0.2, 0.9, 0.1, 0.5}) score.errors.push_back({score.errors.size(), error, 0});
  const auto worst = worst_relations(score, 2);
  ASSERT_EQ(worst.size(), 2U);
  EXPECT_EQ(worst[0].relation, 1U);
  EXPECT_EQ(worst[1].relation, 3U);
  EXPECT_EQ(worst_relations(score, 9).size(), 4U);
  EXPECT_TRUE(worst_relations(score, 0).empty());
}

TEST(Relations, FilesAreReadAndChecked) {
  const TemporaryFolder folder;
  const auto read =
      read_relations(folder.write("a", "# comment\n\n3 7 1 2 0.5 0.1 0.2 -0.25\n7 3 1e-1 0 0 0 0 7 \r\n"));
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[0].from, 3U);
  EXPECT_EQ((*read)[0].to, 7U);
  EXPECT_EQ((*read)[0].from_T_to.y, 2);
  EXPECT_EQ((*read)[0].from_T_to.yaw, -0.25);
  EXPECT_NEAR((*read)[1].from_T_to.yaw, 7 - 2 * M_PI, 1e-12);
  const auto complaint = [&](const std::string& text) {
    const auto bad = read_relations(folder.write("b", text));
    return bad ? "" : bad.error().message;
  };
  EXPECT_NE(complaint("0 1 1 2 3 4 5 6\n0 1 1 2 3 4 5\n").find("line 2: expected 'i j x y z"),
            std::string::npos);
  EXPECT_NE(complaint("-1 1 1 2 3 4 5 6\n").find("no whole numbers"), std::string::npos);
  EXPECT_NE(complaint("0.5 1 1 2 3 4 5 6\n").find("no whole numbers"), std::string::npos);
  EXPECT_NE(complaint("0 1e30 1 2 3 4 5 6\n").find("no whole numbers"), std::string::npos);
  EXPECT_NE(complaint("0 1 nan 2 3 4 5 6\n").find("line 1"), std::string::npos);
  EXPECT_NE(complaint("# nothing\n").find("holds no relations"), std::string::npos);
  EXPECT_EQ(read_relations(folder.path() / "none").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(read_relations(folder.path()).error().code, ErrorCode::kNotFound);
}

/// A drive along x with a scan every 0.1 s, whose odometry is 2 % long.
std::vector<ScanMoment> drive(std::size_t scans) {
  std::vector<ScanMoment> moments;
  for (std::size_t i = 0; i < scans; ++i) {
    const auto step = static_cast<double>(i);
    moments.push_back({i, 100 + 0.1 * step, Pose2{1.02 * step, 0, 0}});
  }
  return moments;
}

TEST(PosesOfScans, AsManyPosesAsScansBelongOneByOne) {
  auto moments = drive(3);
  moments[2].index = 5;  // two scans of the recording were damaged
  const auto poses = poses_of_scans({{0, {1, 0, 0}}, {0, {2, 0, 0}}, {0, {3, 0, 0}}}, moments);
  ASSERT_TRUE(poses);
  ASSERT_EQ(poses->size(), 6U);
  EXPECT_EQ((*poses)[1]->x, 2);
  EXPECT_FALSE((*poses)[3]);
  EXPECT_EQ((*poses)[5]->x, 3);
}

TEST(PosesOfScans, OdometryFillsWhatLiesBetween) {
  const auto moments = drive(11);
  const Trajectory trajectory = {{100.2, {2, 5, 0}}, {100.6, {6, 5, 0}}, {101.0, {10, 5, 0}}};
  const auto poses = poses_of_scans(trajectory, moments);
  ASSERT_TRUE(poses) << poses.error().message;
  EXPECT_FALSE((*poses)[0] || (*poses)[1]) << "before the first pose";
  for (std::size_t i = 2; i <= 10; ++i) {
    ASSERT_TRUE((*poses)[i]) << i;
    EXPECT_NEAR((*poses)[i]->x, static_cast<double>(i), 1e-9) << "odometry is bent to end at the next pose";
    EXPECT_NEAR((*poses)[i]->y, 5, 1e-9);
  }
}

TEST(PosesOfScans, StampsMayRunBackwards) {
  auto moments = drive(8);
  moments[4].stamp_s = moments[1].stamp_s;  // the same stamp twice: order decides
  const Trajectory trajectory = {{moments[0].stamp_s, {0, 0, 0}},
                                 {moments[3].stamp_s, {3, 0, 0}},
                                 {moments[4].stamp_s, {4, 0, 0}},
                                 {moments[7].stamp_s, {7, 0, 0}}};
  const auto poses = poses_of_scans(trajectory, moments);
  ASSERT_TRUE(poses) << poses.error().message;
  for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR((*poses)[i]->x, static_cast<double>(i), 1e-9);
}

TEST(PosesOfScans, WithoutOdometryNothingIsInterpolated) {
  auto moments = drive(3);
  moments[0].odom_T_base.reset();
  const auto poses = poses_of_scans({{100.0, {}}, {100.2, {}}}, moments);
  ASSERT_TRUE(poses);
  EXPECT_TRUE((*poses)[0] && (*poses)[2]);
  EXPECT_FALSE((*poses)[1]);
}

TEST(PosesOfScans, AForeignTrajectoryIsRefused) {
  const auto poses = poses_of_scans({{100.0, {}}, {100.05, {}}}, drive(5));
  ASSERT_FALSE(poses);
  EXPECT_NE(poses.error().message.find("100.05"), std::string::npos);
  EXPECT_NE(poses.error().message.find("pose 1"), std::string::npos);
}

}  // namespace
}  // namespace extperfc::offline
