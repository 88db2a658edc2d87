// A simulated robot in a room, followed from scan to scan.
#include <gtest/gtest.h>

#include "mapping/tracker.hpp"
#include "test/support/planar_world.hpp"

namespace extperfc::mapping {
namespace {

constexpr double kMinimumFit = 0.4;

const std::vector<Eigen::Vector2d>& corners() {
  static const std::vector<Eigen::Vector2d> kCorners{{-3, -1.5}, {2, -1.5}, {3, 1},
                                                     {0, 1.2},   {-2, 0},   {-3, -1.5}};
  return kCorners;
}

/// Drives once around the room; where odometry comes from is the test's business.
class Drive {
 public:
  explicit Drive(std::uint64_t seed, double step_m = 0.1, double step_rad = 0.1)
      : rng_(seed), truth_(planar_drive(corners(), step_m, step_rad)) {}

  [[nodiscard]] std::size_t size() const { return truth_.size(); }
  [[nodiscard]] Pose2 truth(std::size_t i) const { return between(truth_.front(), truth_[i]); }
  [[nodiscard]] Pose2 step(std::size_t i) const {
    return i == 0 ? Pose2{} : between(truth_[i - 1], truth_[i]);
  }
  ScanPoints points(std::size_t i) { return scan_points(scanner_.scan(world_, truth_[i], rng_), {}); }
  Rng& rng() { return rng_; }
  [[nodiscard]] double error_m(const Pose2& pose, std::size_t i) const {
    const Pose2 off = between(truth(i), pose);
    return std::hypot(off.x, off.y);
  }
  [[nodiscard]] double error_rad(const Pose2& pose, std::size_t i) const {
    return std::abs(between(truth(i), pose).yaw);
  }

 private:
  Rng rng_;
  std::vector<Pose2> truth_;
  PlanarWorld world_{planar_room()};
  PlanarScanner scanner_;
};

// Ranges are off by 1 cm and some hundred of them bear on each pose: a few millimetres a pose, and as the map
// of the room stays in memory for 25 to 50 scans, drift over 15 m stays within some centimetres.
constexpr double kRoomErrorM = 0.06;
constexpr double kRoomErrorRad = 0.02;

TEST(Tracker, FollowsNoisyOdometry) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SCOPED_TRACE(seed);
    Drive drive(seed);
    PlanarOdometry odometry;
    Tracker tracker({}, kMinimumFit);
    for (std::size_t i = 0; i < drive.size(); ++i) {
      const auto tracked = tracker.add(drive.points(i), odometry.move(drive.step(i), drive.rng()));
      EXPECT_TRUE(tracked.matched) << i;
      EXPECT_FALSE(tracked.odometry_contradicted) << i;
      EXPECT_GT(tracked.fit, 0.8) << i;
      ASSERT_LT(drive.error_m(tracked.pose, i), kRoomErrorM) << i;
      ASSERT_LT(drive.error_rad(tracked.pose, i), kRoomErrorRad) << i;
    }
    EXPECT_GT(drive.error_m(odometry.pose, drive.size() - 1), 0.2) << "odometry alone would not do";
  }
}

TEST(Tracker, FollowsWithoutOdometry) {
  for (const std::uint64_t seed : {4U, 5U}) {
    SCOPED_TRACE(seed);
    Drive drive(seed, 0.07, 0.07);
    Tracker tracker({}, kMinimumFit);
    for (std::size_t i = 0; i < drive.size(); ++i) {
      const auto tracked = tracker.add(drive.points(i), std::nullopt);
      EXPECT_FALSE(tracked.odometry_contradicted) << i;
      ASSERT_LT(drive.error_m(tracked.pose, i), kRoomErrorM) << i;
      ASSERT_LT(drive.error_rad(tracked.pose, i), kRoomErrorRad) << i;
    }
  }
}

TEST(Tracker, OdometryMayComeAndGo) {
  Drive drive(6, 0.07, 0.07);
  PlanarOdometry odometry;
  Tracker tracker({}, kMinimumFit);
  for (std::size_t i = 0; i < drive.size(); ++i) {
    const Pose2 wheels = odometry.move(drive.step(i), drive.rng());
    const bool there = (i / 15) % 2 == 0;
    const auto tracked = tracker.add(drive.points(i), there ? std::optional<Pose2>(wheels) : std::nullopt);
    ASSERT_LT(drive.error_m(tracked.pose, i), kRoomErrorM) << i;
  }
}

TEST(Tracker, SlippingWheels) {
  for (const double slip_m : {0.3, -0.3}) {
    SCOPED_TRACE(slip_m);
    Drive drive(7);
    PlanarOdometry odometry;
    Tracker tracker({}, kMinimumFit);
    std::size_t contradicted = 0;
    for (std::size_t i = 0; i < drive.size(); ++i) {
      odometry.move(drive.step(i), drive.rng());
      if (i == 30) odometry.pose = compose(odometry.pose, {slip_m, 0, 0});
      const auto tracked = tracker.add(drive.points(i), odometry.pose);
      if (tracked.odometry_contradicted) ++contradicted;
      ASSERT_LT(drive.error_m(tracked.pose, i), kRoomErrorM) << i;
    }
    EXPECT_LE(contradicted, 1U);
  }
}

/// Wheels that are always a quarter off, where the walls constrain the pose.
TEST(Tracker, WrongWheelsDoNotCountInARoom) {
  for (const double scale : {0.25, -0.25}) {
    SCOPED_TRACE(scale);
    Drive drive(14);
    PlanarOdometry odometry;
    odometry.scale = scale;
    Tracker tracker({}, kMinimumFit);
    double wheels_off_m = 0;
    for (std::size_t i = 0; i < drive.size(); ++i) {
      const auto tracked = tracker.add(drive.points(i), odometry.move(drive.step(i), drive.rng()));
      ASSERT_LT(drive.error_m(tracked.pose, i), kRoomErrorM) << i;
      wheels_off_m = std::max(wheels_off_m, drive.error_m(odometry.pose, i));
    }
    EXPECT_GT(wheels_off_m, 1.0) << "odometry alone must not do";
  }
}

/// A drive of 12 m along a corridor that does not constrain the position along it.
struct CorridorDrive {
  PlanarScanner scanner;
  double pedestrians_pace{1};  ///< of two people ahead, against the robot's
  bool pedestrians{false};
  double tracked_m{0};  ///< along the corridor, at the end
  double aside_m{0};
  double odometry_m{0};

  static constexpr double kStepM = 0.1;
  static constexpr int kSteps = 120;
  static constexpr double kLengthM = kStepM * kSteps;

  void drive(std::uint64_t seed) {
    Rng rng(seed);
    PlanarOdometry odometry;
    odometry.veer_rad_per_m = 0;
    Tracker tracker({}, kMinimumFit);
    for (int i = 0; i <= kSteps; ++i) {
      const double distance = i * kStepM;
      PlanarWorld world = planar_corridor();
      if (pedestrians) {
        const double ahead = -4 + pedestrians_pace * distance;  // 6 m at first
        world.add_box(ahead, 0.1, ahead + 0.3, 0.6);
        world.add_box(ahead + 0.2, -0.6, ahead + 0.5, -0.1);
      }
      const Pose2 step{i == 0 ? 0.0 : kStepM, 0, 0};
      const auto scan = scanner.scan(world, {-10 + distance, 0, 0}, rng);
      (void)tracker.add(scan_points(scan, {}), odometry.move(step, rng));
    }
    tracked_m = tracker.pose().x;
    aside_m = tracker.pose().y;
    odometry_m = odometry.pose.x;
  }
};

PlanarScanner half_circle_scanner() {
  PlanarScanner scanner;
  scanner.rays = 181;
  scanner.angle_min = -M_PI / 2;
  scanner.angle_increment = M_PI / 180;
  scanner.range_max = 8;
  return scanner;
}

PlanarScanner turning_scanner() {
  PlanarScanner scanner;
  scanner.rays = 900;
  scanner.angle_increment = 2 * M_PI / 900;
  scanner.range_max = 30;
  return scanner;
}

// Along a corridor the pose may leave odometry by 1 cm and by srr of the way, and is given back what is more.
constexpr double kOffWheelsM = 0.01 + 0.1 * CorridorDrive::kLengthM;

/// Two people walk 6 m ahead at the robot's pace or nearly so: what the scan tells along the corridor is that
/// the robot stands still, or is slow. (Nearer they fill so much of the scan that they still count.)
TEST(Tracker, WalkersInACorridorDoNotHoldItBack) {
  for (const double pace : {0.85, 1.0, 1.2})
    for (const std::uint64_t seed : {11U, 12U, 13U}) {
      SCOPED_TRACE(testing::Message() << "pace " << pace << ", seed " << seed);
      CorridorDrive run{half_circle_scanner(), pace, true};
      run.drive(seed);
      EXPECT_NEAR(run.tracked_m, run.odometry_m, kOffWheelsM);
      EXPECT_NEAR(run.aside_m, 0, 0.1);
    }
}

/// A hall whose walls are out of range, and one person who walks along with the robot, or comes towards it:
/// all that is seen says that the robot stands, or is twice as fast.
TEST(Tracker, APersonAloneInAHallMovesNobody) {
  for (const double pace : {1.0, 0.9, -0.5})
    for (const std::uint64_t seed : {18U, 19U, 20U}) {
      SCOPED_TRACE(testing::Message() << "pace " << pace << ", seed " << seed);
      Rng rng(seed);
      PlanarOdometry odometry;
      odometry.veer_rad_per_m = 0;
      Tracker tracker({}, kMinimumFit);
      for (int i = 0; i <= 60; ++i) {
        const double ahead_m = (pace < 0 ? 6.5 : 1.5) + pace * 0.1 * i;
        PlanarWorld world;
        world.add_box(ahead_m, 0.3, ahead_m + 0.3, 0.8);
        const auto scan = half_circle_scanner().scan(world, {0.1 * i, 0, 0}, rng);
        (void)tracker.add(scan_points(scan, {}), odometry.move({i == 0 ? 0.0 : 0.1, 0, 0}, rng));
      }
      EXPECT_NEAR(tracker.pose().x, odometry.pose.x, 0.6);
      // What is within the error of wheels still follows the person.
      EXPECT_NEAR(tracker.pose().y, odometry.pose.y, 0.8);
      EXPECT_NEAR(tracker.pose().yaw, odometry.pose.yaw, 0.3);
    }
}

/// Nothing but two walls and noise: neither may noise pull the pose along them.
TEST(Tracker, NoiseOfABareCorridorDoesNotHoldItBack) {
  for (const double sigma_m : {0.01, 0.04})
    for (const std::uint64_t seed : {15U, 16U, 17U}) {
      SCOPED_TRACE(testing::Message() << "noise " << sigma_m << " m, seed " << seed);
      CorridorDrive run{half_circle_scanner()};
      run.scanner.sigma_m = sigma_m;
      run.drive(seed);
      EXPECT_NEAR(run.tracked_m, run.odometry_m, kOffWheelsM);
      EXPECT_NEAR(run.aside_m, 0, 0.1);
    }
}

/// A corridor with door frames, along which the robot drives until a person stands in its path: it pushes,
/// and the wheels spin. Then the person goes away.
struct SpinningWheels {
  PlanarScanner scanner;
  double spin_m{2.5};   ///< what the wheels report meanwhile
  double step_m{0.05};  ///< from scan to scan
  double off_m{0};      ///< of the tracked pose, at the end, along the corridor

  void drive(std::uint64_t seed) {
    constexpr double kBeforeM = 8;
    constexpr double kAfterM = 6;
    Rng rng(seed);
    PlanarWorld world = planar_corridor();
    for (const double x : {-22.0, -18.7, -16.5, -13.0, -10.2, -8.0, -4.4, -1.7, 1.0, 4.6, 7.1, 9.5})
      for (const double y : {-1.0, 0.85}) world.add_box(x + y, y, x + y + 0.9, y + 0.15);
    PlanarWorld with_person = world;
    with_person.add_box(-12 + kBeforeM + 0.5, -0.25, -12 + kBeforeM + 0.8, 0.25);
    PlanarOdometry odometry;
    odometry.veer_rad_per_m = 0;
    Tracker tracker({}, kMinimumFit);
    double moved_m = 0;
    double spun_m = 0;
    while (moved_m < kBeforeM + kAfterM) {
      const bool blocked = moved_m >= kBeforeM && spun_m < spin_m;
      (blocked ? spun_m : moved_m) += step_m;
      const auto scan = scanner.scan(blocked ? with_person : world, {-12 + moved_m, 0, 0}, rng);
      (void)tracker.add(scan_points(scan, {}), odometry.move({step_m, 0, 0}, rng));
    }
    off_m = tracker.pose().x - moved_m + step_m;
  }
};

/// A coarse scanner sees too little that faces along the corridor; one that turns as a VLP-16 does sees
/// enough.
TEST(Tracker, WheelsThatSpinInACorridorAreFoundOut) {
  for (const double spin_m : {0.3, 2.5})
    for (const std::uint64_t seed : {21U, 22U, 23U}) {
      SCOPED_TRACE(testing::Message() << "spin " << spin_m << " m, seed " << seed);
      SpinningWheels run;
      run.spin_m = spin_m;
      run.scanner = turning_scanner();
      run.drive(seed);
      EXPECT_NEAR(run.off_m, 0, 0.12);
    }
}

/// The opposite: the robot moves, and people ahead who walk more slowly, or at its pace, speak against it.
TEST(Tracker, WheelsThatTurnTheRobotAreNotTakenForSpinning) {
  for (const double pace : {0.3, 0.6, 1.0})
    for (const std::uint64_t seed : {24U, 25U, 26U}) {
      SCOPED_TRACE(testing::Message() << "pace " << pace << ", seed " << seed);
      CorridorDrive run{turning_scanner(), pace, true};
      run.drive(seed);
      EXPECT_NEAR(run.tracked_m, run.odometry_m, kOffWheelsM);
    }
}

TEST(Tracker, JumpOfOdometry) {
  for (const Pose2& jump : {Pose2{5, -2, 1.0}, Pose2{0, 0, 2.5}, Pose2{-300, 200, 0}}) {
    SCOPED_TRACE(jump.x);
    Drive drive(8);
    PlanarOdometry odometry;
    Tracker tracker({}, kMinimumFit);
    for (std::size_t i = 0; i < drive.size(); ++i) {
      odometry.move(drive.step(i), drive.rng());
      if (i == 40) odometry.pose = compose(jump, odometry.pose);
      const auto tracked = tracker.add(drive.points(i), odometry.pose);
      if (i == 40) {
        EXPECT_TRUE(tracked.odometry_contradicted);
      }
      ASSERT_LT(drive.error_m(tracked.pose, i), kRoomErrorM) << i;
    }
  }
}

TEST(Tracker, OdometryThatNeverMoves) {
  constexpr double kLagM = 0.2;  // a scan that is less than a decimetre off still fits where the robot stood
  Drive drive(9, 0.07, 0.07);
  Tracker tracker({}, kMinimumFit);
  for (std::size_t i = 0; i < drive.size(); ++i) {
    const auto tracked = tracker.add(drive.points(i), Pose2{1, 2, 3});
    ASSERT_LT(drive.error_m(tracked.pose, i), kLagM) << i;
  }
}

TEST(Tracker, StandingStillDoesNotDrift) {
  Drive drive(10);
  Tracker tracker({}, kMinimumFit);
  for (int i = 0; i < 200; ++i) {
    const auto tracked = tracker.add(drive.points(0), Pose2{1, 2, 0.5});
    ASSERT_LT(drive.error_m(tracked.pose, 0), 0.005) << i;
    ASSERT_LT(drive.error_rad(tracked.pose, 0), 0.003) << i;
  }
}

TEST(Tracker, EmptyScansCoastOnOdometry) {
  Drive drive(11);
  PlanarOdometry odometry;
  Tracker tracker({}, kMinimumFit);
  Pose2 before;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    const Pose2 earlier = odometry.pose;
    const Pose2 wheels = odometry.move(drive.step(i), drive.rng());
    const bool blind = i >= 20 && i < 26;
    const auto tracked = tracker.add(blind ? ScanPoints{} : drive.points(i), wheels);
    EXPECT_EQ(tracked.matched, !blind) << i;
    if (blind) {
      const Pose2 expected = compose(before, between(earlier, wheels));
      EXPECT_NEAR(tracked.pose.x, expected.x, 1e-12);
      EXPECT_NEAR(tracked.pose.y, expected.y, 1e-12);
      EXPECT_NEAR(tracked.pose.yaw, expected.yaw, 1e-12);
      EXPECT_EQ(tracked.fit, 0.0);
    } else {
      ASSERT_LT(drive.error_m(tracked.pose, i), kRoomErrorM) << i;
    }
    before = tracked.pose;
  }
}

/// What no scan measured is as uncertain as the wheels are: a loop closure after a hall that is wider than
/// the scanner sees is looked for as far off as they may be.
TEST(Tracker, WhatWheelsAloneMeasureIsDoubted) {
  Drive drive(12);
  const OdometryNoise noise;
  Tracker tracker(noise, kMinimumFit);
  for (int i = 0; i < 20; ++i) (void)tracker.add(drive.points(0), Pose2{});
  constexpr double kStepM = 0.1;
  constexpr int kSteps = 100;
  Eigen::Matrix3d doubt = Eigen::Matrix3d::Zero();
  for (int i = 1; i <= kSteps; ++i) doubt += tracker.add({}, Pose2{kStepM * i, 0, 0}).doubt;
  const double root_m = std::sqrt(kStepM * kSteps);
  EXPECT_NEAR(std::sqrt(doubt(0, 0)), noise.srr * root_m, 1e-9);
  EXPECT_NEAR(std::sqrt(doubt(2, 2)), noise.srt * root_m, 1e-9);
}

TEST(Tracker, InformationIsSymmetricAndPositive) {
  Drive drive(12);
  PlanarOdometry odometry;
  Tracker tracker({}, kMinimumFit);
  for (std::size_t i = 0; i < 60; ++i) {
    const auto tracked =
        tracker.add(i % 7 == 3 ? ScanPoints{} : drive.points(i), odometry.move(drive.step(i), drive.rng()));
    EXPECT_LT((tracked.information - tracked.information.transpose()).cwiseAbs().maxCoeff(),
              1e-9 * tracked.information.cwiseAbs().maxCoeff());
    EXPECT_GT(tracked.information(0, 0), 0);
    EXPECT_GT((tracked.information.topLeftCorner<2, 2>().determinant()), 0);
    EXPECT_GT(tracked.information.determinant(), 0);
  }
}

TEST(Tracker, GoesOnAStepAway) {
  Drive drive(13);
  std::vector<KeyFrame> frames;
  std::vector<Pose2> poses;
  for (std::size_t i = 0; i < 50; i += 3) {
    frames.push_back({i, 0.1 * static_cast<double>(i), drive.points(i)});
    poses.push_back(drive.truth(i));
  }
  Tracker tracker({}, kMinimumFit);
  tracker.resume_from(frames, poses, drive.truth(50));
  EXPECT_EQ(tracker.pose().x, drive.truth(50).x);
  constexpr std::size_t kAway = 55;  // 0.7 m on
  for (std::size_t i = kAway; i < drive.size(); ++i) {
    const auto tracked = tracker.add(drive.points(i), compose({40, -7, 2}, drive.truth(i)));
    ASSERT_LT(drive.error_m(tracked.pose, i), kRoomErrorM) << i;
  }
}

}  // namespace
}  // namespace extperfc::mapping
