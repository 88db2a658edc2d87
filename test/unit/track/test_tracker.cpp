// Birth, confirmation and death of tracks; objects that cross; images without them; time that runs back.
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <stdexcept>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/track/tracker.hpp"

namespace extperfc::track {
namespace {

constexpr double kDt = 0.1;
constexpr double kSigmaM = 0.01;

Observation seen(const Eigen::Vector3d& position, int class_index = 0) {
  return {class_index, 0.9, position, kSigmaM * kSigmaM * Eigen::Matrix3d::Identity()};
}

class TrackerTest : public testing::Test {
 protected:
  /// Shows the objects `times` times, kDt apart.
  void show(const std::vector<Observation>& observations, int times = 1) {
    for (int i = 0; i < times; ++i) {
      now_s_ += kDt;
      ASSERT_EQ(tracker_.update(now_s_, observations), Tracker::Status::kUpdated);
    }
  }
  [[nodiscard]] const std::vector<Track>& tracks() const { return tracker_.tracks(); }

  TrackerParams params_;
  Tracker tracker_{params_};
  double now_s_{1000.0};
};

TEST_F(TrackerTest, AnObjectIsConfirmedAfterSomeObservations) {
  for (int hits = 1; hits <= 5; ++hits) {
    show({seen({0, 0, 1})});
    ASSERT_EQ(tracks().size(), 1U);
    EXPECT_EQ(tracks()[0].id, 1U);
    EXPECT_EQ(tracks()[0].hits, hits);
    EXPECT_EQ(tracks()[0].confirmed, hits >= params_.confirm_hits);
    EXPECT_EQ(tracks()[0].observation, 0U);
  }
  EXPECT_NEAR(tracks()[0].first_seen_s, 1000.1, 1e-9);
  EXPECT_NEAR(tracks()[0].last_seen_s, 1000.5, 1e-9);
}

TEST_F(TrackerTest, AFalseDetectionIsForgottenSoon) {
  show({seen({0, 0, 1})});
  show({}, 2);
  EXPECT_EQ(tracks().size(), 1U);
  show({});
  EXPECT_TRUE(tracks().empty()) << "0.3 s without an observation";
}

TEST_F(TrackerTest, AConfirmedObjectSurvivesMissedImagesAndKeepsItsId) {
  show({seen({0, 0, 1})}, 5);
  show({}, 8);
  ASSERT_EQ(tracks().size(), 1U);
  EXPECT_FALSE(tracks()[0].observation);
  show({seen({0.01, 0, 1})});
  ASSERT_EQ(tracks().size(), 1U);
  EXPECT_EQ(tracks()[0].id, 1U);
  show({}, 11);
  EXPECT_TRUE(tracks().empty());
  show({seen({0, 0, 1})});
  EXPECT_EQ(tracks()[0].id, 2U) << "an id is never given twice";
}

TEST_F(TrackerTest, AnOldObjectDoesNotSwallowANewOneAfterALongGap) {
  show({seen({0, 0, 1})}, 5);
  now_s_ += 60.0;
  show({seen({0.3, 0, 1})});
  ASSERT_EQ(tracks().size(), 1U);
  EXPECT_EQ(tracks()[0].id, 2U);
}

TEST_F(TrackerTest, AMissedObjectMovesOn) {
  const double speed = 0.5;
  double x = 0.0;
  for (int i = 0; i < 20; ++i) show({seen({x += speed * kDt, 0, 1})});
  show({}, 5);
  ASSERT_EQ(tracks().size(), 1U);
  EXPECT_NEAR(tracks()[0].point.position_m().x(), x + 5 * speed * kDt, 0.03);
  EXPECT_NEAR(tracks()[0].point.velocity_m_s().x(), speed, 0.05);
}

TEST_F(TrackerTest, CrossingObjectsKeepTheirIds) {
  // Two balls pass each other on lines 6 cm apart, with noise; nearest boxes alone would swap them.
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    Tracker tracker(params_);
    std::uint64_t left = 0;
    for (int i = 0; i <= 40; ++i) {
      const double x = -0.6 + 0.03 * i;
      const auto noise = [&] { return rng.normal(0, 0.005); };
      std::vector<Observation> both{seen({x + noise(), 0.03 + noise(), 1 + noise()}),
                                    seen({-x + noise(), -0.03 + noise(), 1 + noise()})};
      if (i % 2 == 1) std::swap(both[0], both[1]);  // the order of detections means nothing
      tracker.update(10 + kDt * i, both);
      ASSERT_EQ(tracker.tracks().size(), 2U) << "image " << i;
      const auto& first = tracker.tracks()[0];
      if (i == 0) left = first.id;
      EXPECT_EQ(first.id, left);
      EXPECT_NEAR(first.point.position_m().x(), x, 0.05) << "image " << i;
    }
  }
}

/// From one update to the next, as people do; at 1.4 m/s along a corridor.
TEST_F(TrackerTest, WhoTurnsRoundKeepsTheIdWhereManoeuvresAreAllowed) {
  for (const bool allowed : {false, true}) {
    TrackerParams params = params_;
    params.manoeuvre_m_s = allowed ? 1.2 : 0;
    Tracker tracker(params);
    Rng rng(5);
    std::uint64_t id = 0;
    for (int i = 0; i < 60; ++i) {
      const double along_m = 0.14 * (i < 30 ? i : 60 - i);
      tracker.update(now_s_ += kDt, {seen({along_m + rng.normal(0, kSigmaM), 0, 1})});
      if (i == 25) id = tracker.tracks()[0].id;
    }
    ASSERT_EQ(tracker.tracks().size(), 1U);
    EXPECT_EQ(tracker.tracks()[0].id == id, allowed);
    EXPECT_LT(tracker.tracks()[0].point.velocity_m_s().x(), -1.0);
  }
}

TEST_F(TrackerTest, AManoeuvreTakesNoObservationFromWhoGoesOn) {
  params_.manoeuvre_m_s = 1.2;
  tracker_ = Tracker(params_);
  for (int i = 0; i < 30; ++i) show({seen({0.1 * i, 0, 1}), seen({0.1 * i, 0.3, 1})});
  for (int i = 30; i < 33; ++i) show({seen({0.1 * i, 0, 1})});  // the second is hidden
  ASSERT_EQ(tracks().size(), 2U);
  EXPECT_EQ(tracks()[0].observation, 0U);
  EXPECT_FALSE(tracks()[1].observation);
  EXPECT_NEAR(tracks()[1].point.position_m().y(), 0.3, 0.02);
}

TEST_F(TrackerTest, ObjectsOfDifferentClassesDoNotSwap) {
  show({seen({-0.02, 0, 1}, 0), seen({0.02, 0, 1}, 1)}, 5);
  show({seen({0.004, 0, 1}, 0), seen({-0.004, 0, 1}, 1)});  // positions alone would say: swapped
  ASSERT_EQ(tracks().size(), 2U);
  EXPECT_EQ(tracks()[0].observation, 0U);
  EXPECT_EQ(tracks()[1].observation, 1U);
}

TEST_F(TrackerTest, OneWrongClassDoesNotChangeAnObjects) {
  show({seen({0, 0, 1}, 2)}, 5);
  show({seen({0, 0, 1}, 7)});
  ASSERT_EQ(tracks().size(), 1U);
  EXPECT_EQ(tracks()[0].class_index(), 2);
  show({seen({0, 0, 1}, 7)}, 10);
  EXPECT_EQ(tracks()[0].class_index(), 7);
  EXPECT_EQ(tracks()[0].id, 1U);
}

TEST_F(TrackerTest, TheFilterIsMoreExactThanTheMeasurements) {
  Rng rng(5);
  const Eigen::Vector3d truth(0.2, 0.1, 0.8);
  double raw2 = 0;
  double filtered2 = 0;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d measured =
        truth + Eigen::Vector3d(rng.normal(0, kSigmaM), rng.normal(0, kSigmaM), rng.normal(0, kSigmaM));
    show({seen(measured)});
    if (i < 20) continue;
    raw2 += (measured - truth).squaredNorm();
    filtered2 += (tracks()[0].point.position_m() - truth).squaredNorm();
  }
  EXPECT_LT(std::sqrt(filtered2 / raw2), 0.8);
  EXPECT_EQ(tracks().size(), 1U);
}

TEST_F(TrackerTest, TimeThatRunsBackBeginsAnew) {
  show({seen({0, 0, 1})}, 5);
  EXPECT_EQ(tracker_.update(now_s_ - 0.5, {seen({3, 0, 1})}), Tracker::Status::kTooOld);
  EXPECT_EQ(tracks().size(), 1U) << "an image that comes late is ignored";
  EXPECT_NEAR(tracks()[0].point.position_m().x(), 0.0, 1e-6);
  EXPECT_EQ(tracker_.update(5.0, {seen({0, 0, 1})}), Tracker::Status::kRestarted);
  ASSERT_EQ(tracks().size(), 1U);
  EXPECT_EQ(tracks()[0].id, 2U);
  EXPECT_FALSE(tracks()[0].confirmed);
  EXPECT_EQ(tracker_.update(5.1, {seen({0, 0, 1})}), Tracker::Status::kUpdated);
  EXPECT_EQ(tracks()[0].hits, 2);
}

TEST_F(TrackerTest, TheSameStampTwiceIsNoFault) {
  show({seen({0, 0, 1})});
  EXPECT_EQ(tracker_.update(now_s_, {seen({0, 0, 1})}), Tracker::Status::kUpdated);
  ASSERT_EQ(tracks().size(), 1U);
  EXPECT_TRUE(tracks()[0].point.covariance().allFinite());
}

TEST_F(TrackerTest, WhatIsNotFiniteIsLeftOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Observation no_covariance = seen({0, 0, 1});
  no_covariance.covariance_m2(0, 0) = nan;
  show({seen({nan, 0, 1}), no_covariance}, 2);
  EXPECT_TRUE(tracks().empty());
  Observation exact = seen({0, 0, 1});
  exact.covariance_m2.setZero();
  show({exact}, 3);
  ASSERT_EQ(tracks().size(), 1U);
  EXPECT_TRUE(tracks()[0].point.covariance().allFinite());
}

TEST_F(TrackerTest, TheNumberOfObjectsIsBounded) {
  params_.max_tracks = 10;
  Tracker tracker(params_);
  std::vector<Observation> many;
  for (int i = 0; i < 50; ++i) many.push_back(seen({i * 1.0, 0, 1}));
  tracker.update(1.0, many);
  EXPECT_EQ(tracker.tracks().size(), 10U);
}

TEST_F(TrackerTest, RefusesParametersThatCannotBe) {
  for (double TrackerParams::*number :
       {&TrackerParams::acceleration_m_s2, &TrackerParams::speed_m_s, &TrackerParams::min_sigma_m,
        &TrackerParams::gate, &TrackerParams::max_missed_s, &TrackerParams::max_missed_new_s})
    for (const double bad : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
      TrackerParams params;
      params.*number = bad;
      EXPECT_FALSE(validate(params));
      EXPECT_THROW(Tracker{params}, std::invalid_argument);
    }
  TrackerParams params;
  params.manoeuvre_m_s = -1;
  EXPECT_FALSE(validate(params));
  params = {};
  params.confirm_hits = 0;
  const auto valid = validate(params);
  ASSERT_FALSE(valid);
  EXPECT_EQ(valid.error().message, "tracker: confirm_hits must be at least 1, not 0.000000");
}

}  // namespace
}  // namespace extperfc::track
