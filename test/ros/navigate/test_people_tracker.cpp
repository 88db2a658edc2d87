// People from scan to scan: who walks is followed, and furniture that the robot passes is none of them.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"

#include "ros/navigate/people_tracker.hpp"
#include "test/support/building.hpp"

namespace extperfc::ros_navigate {
namespace {

constexpr double kScanS = 0.1;

/// A room of 8 x 6 m that is on the map, and a robot that looks about in it; odom is the map.
struct Hall {
  Building mapped;
  Building seen;  ///< with what the map does not have
  std::vector<FloorDisc> discs;
  PeopleTracker tracker{ros_params::PeopleParams{}};
  double now_s{10};
  Rng rng{3};

  Hall() {
    mapped.size_m = {8, 6};
    mapped.enclose();
    seen = mapped;
    tracker.set_map(occupancy_of(mapped));
  }
  void look(const Pose2& pose) {
    now_s += kScanS;
    PlacedScan placed{scan_of(seen, discs, pose, rng), pose, Pose2{}};
    placed.scan.stamp_s = now_s;
    tracker.update(placed);
  }
  /// While the first disc, the only person, walks along x.
  void look_at_walk(const Pose2& pose, double speed_m_s, int scans) {
    for (int i = 0; i < scans; ++i) {
      discs[0].at_m.x() += speed_m_s * kScanS;
      look(pose);
    }
  }
  /// In every scan there is one person: the first disc, which stands.
  void expect_person(const Pose2& pose, int scans) {
    for (int i = 0; i < scans; ++i) {
      look(pose);
      const auto people = tracker.people(now_s);
      ASSERT_EQ(people.size(), 1U) << "after " << i * kScanS << " s";
      EXPECT_LT((people[0].position_m - discs[0].at_m).norm(), 0.35);
    }
  }
};

/// The scan of clouds shows the edge of a table's top, of which the map has the legs at most. As the robot
/// passes, another part of the edge comes into sight, and what the tracker has of it seems to walk.
TEST(PeopleTracker, ATableIsNobody) {
  int looks = 0;
  int wrong = 0;
  for (int table = 0; table < 6; ++table) {
    Hall hall;
    hall.rng = Rng(static_cast<std::uint64_t>(table) + 1);
    const Eigen::Vector2d half_m(hall.rng.uniform(0.3, 0.8), hall.rng.uniform(0.25, 0.45));
    const Eigen::Vector2d middle_m(hall.rng.uniform(3.5, 4.5), hall.rng.uniform(2.7, 3.3));
    hall.seen.boxes.push_back({{middle_m.x(), middle_m.y(), hall.rng.uniform(-kPi, kPi)}, half_m});
    Pose2 pose;
    const double around_rad = hall.rng.uniform(-kPi, kPi);
    const double away_m = half_m.norm() + hall.rng.uniform(0.5, 0.9);
    for (int step = 0; step < 250; ++step) {  // around the table at 0.5 m/s, looking here and there
      const double angle = around_rad + 0.5 * kScanS * step / away_m;
      pose = {middle_m.x() + away_m * std::cos(angle), middle_m.y() + away_m * std::sin(angle),
              wrap_angle(angle + kPi + std::sin(0.12 * step))};
      hall.look(pose);
    }
    for (int step = 0; step < 100; ++step) {  // and stands before it
      hall.look(pose);
      ++looks;
      if (!hall.tracker.people(hall.now_s).empty()) ++wrong;
    }
  }
  EXPECT_LE(wrong, looks / 100) << "of " << looks;
}

TEST(PeopleTracker, WhoWalkedAndStandsBesideACupboardStaysAPerson) {
  Hall hall;
  hall.seen.add(5.0, 2.3, 6.0, 2.6);
  const Pose2 pose{2, 3, 0};
  hall.discs.push_back({{5.5, 5.0}, 0.22});
  while (hall.discs[0].at_m.y() > 2.95) {
    hall.look(pose);
    hall.discs[0].at_m.y() -= 0.6 * kScanS;
  }
  for (int step = 0; step < 20; ++step) hall.look(pose);  // the cupboard seems to walk where it is hidden
  hall.expect_person(pose, 80);
}

/// Two steps towards the robot after turning round are no metre: only who is the same as before is a person.
TEST(PeopleTracker, WhoTurnsRoundAndStopsStaysAPerson) {
  Hall hall;
  const Pose2 pose{1.5, 3, 0};
  hall.discs.push_back({{3.0, 3.0}, 0.22});
  hall.look_at_walk(pose, 1.3, 30);
  hall.look_at_walk(pose, -1.3, 5);
  hall.expect_person(pose, 30);
}

/// Seven decimetres straight to the robot: the place where the walk began is hidden by who walked there.
TEST(PeopleTracker, WhoComesAFewStepsAndStandsIsAPerson) {
  Hall hall;
  const Pose2 pose{1.5, 3, 0};
  hall.discs.push_back({{4.0, 3.0}, 0.22});
  hall.look(pose);
  hall.look_at_walk(pose, -0.9, 8);
  hall.expect_person(pose, 30);
}

}  // namespace
}  // namespace extperfc::ros_navigate
