// Objects from detections in image after image.
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/arm/object_list.hpp"
#include "extperfc/base/rng.hpp"

namespace extperfc::arm {
namespace {

constexpr double kPeriod = 0.1;  // [s] between images

ObjectDetection seen(const std::string& label, double x, double y = 0.0, double yaw = 0.0,
                     const Eigen::Vector3d& size = {0.05, 0.05, 0.05}) {
  return {label, {{x, y, 0.7}, yaw, size}};
}

/// A list, and a scene that takes what is listed.
class Listing {
 public:
  explicit Listing(const ObjectListParams& params = {}) : list_(ObjectList::make(params).value()) {}

  ObjectListUpdate update(const std::vector<ObjectDetection>& detections) {
    time_s += kPeriod;
    const auto done = list_.update(detections, scene, time_s);
    std::vector<KnownObject> next;
    for (const auto& known : scene)
      if (!known.listed) next.push_back(known);
    for (const auto& object : list_.objects()) {
      KnownObject known{object.name, object.label, object.world_T_object, true, false, {}};
      for (const auto& old : scene)
        if (old.name == known.name) known.still = old.still;
      next.push_back(known);
    }
    scene = next;
    return done;
  }
  ObjectListUpdate repeat(int times, const std::vector<ObjectDetection>& detections) {
    ObjectListUpdate done;
    for (int i = 0; i < times; ++i) done = update(detections);
    return done;
  }
  KnownObject& known(const std::string& name) {
    for (auto& one : scene)
      if (one.name == name) return one;
    throw std::out_of_range(name + " is not in the scene");
  }
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& object : list_.objects()) all.push_back(object.name);
    return all;
  }
  [[nodiscard]] Eigen::Vector3d position(std::size_t i = 0) const {
    return list_.objects().at(i).world_T_object.translation();
  }
  [[nodiscard]] ListedObject object(std::size_t i = 0) const { return list_.objects().at(i); }

  std::vector<KnownObject> scene;
  double time_s{100.0};

 private:
  ObjectList list_;
};

using Names = std::vector<std::string>;

TEST(ObjectList, RefusesParametersOutOfRange) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<ObjectListParams> wrong(9);
  wrong[0].confirm = 0;
  wrong[1].max_age_s = -1;
  wrong[2].match_m = nan;
  wrong[3].max_objects = 0;
  wrong[4].min_change_m = nan;
  wrong[5].min_change_rad = -0.1;
  wrong[6].average = 0;
  wrong[7].match_m = 0;
  wrong[8].new_score = nan;
  for (const auto& params : wrong) EXPECT_FALSE(ObjectList::make(params));
}

TEST(ObjectList, JoinsAfterAsManyDetectionsAsAreWanted) {
  Listing list;
  EXPECT_EQ(1, list.update({seen("cube", 0.7)}).waiting);
  EXPECT_FALSE(list.update({seen("cube", 0.7)}).changed);
  EXPECT_EQ(Names{}, list.names());
  EXPECT_TRUE(list.update({seen("cube", 0.7)}).changed);
  EXPECT_EQ(Names{"cube_1"}, list.names());
  EXPECT_EQ("cube", list.object().label);
  EXPECT_FALSE(list.update({seen("cube", 0.7)}).changed);
}

TEST(ObjectList, WhatFlickersRarelyIsNone) {
  Listing list;
  for (int i = 0; i < 20; ++i) {
    list.update({seen("cube", 0.7)});
    list.repeat(3, {});
  }
  EXPECT_EQ(Names{}, list.names());
}

/// The detector takes a gripper for a cube, unsure, image after image.
TEST(ObjectList, LowScoresAddNoObjectButMoveOne) {
  ObjectDetection unsure = seen("cube", 0.7);
  unsure.score = 0.45;
  Listing list;
  EXPECT_EQ(1, list.repeat(20, {unsure}).doubtful);
  EXPECT_EQ(Names{}, list.names());
  list.update({seen("cube", 0.7)});
  list.repeat(20, {unsure});
  EXPECT_EQ(Names{}, list.names()) << "one sure detection is not enough";
  list.repeat(2, {seen("cube", 0.7)});
  EXPECT_EQ(Names{"cube_1"}, list.names());
  unsure.box.position_m.x() = 0.72;
  EXPECT_EQ(0, list.repeat(60, {unsure}).doubtful);
  EXPECT_NEAR(0.72, list.position().x(), 0.001);
}

TEST(ObjectList, OneObjectForEach) {
  Listing list;
  list.repeat(3, {seen("cube", 0.7), seen("cube", 0.8), seen("sphere", 0.9)});
  EXPECT_EQ((Names{"cube_1", "cube_2", "sphere_1"}), list.names());
  // In another order, and each nearer to the other one's place than half way.
  list.repeat(2, {seen("sphere", 0.9), seen("cube", 0.77), seen("cube", 0.71)});
  EXPECT_EQ(3u, list.names().size());
  EXPECT_LT(list.position(0).x(), list.position(1).x());
}

TEST(ObjectList, OneObjectThatIsDetectedTwiceIsOne) {
  Listing list;
  const auto done = list.repeat(10, {seen("cube", 0.7), seen("cube", 0.71), seen("sphere", 0.705)});
  EXPECT_EQ(Names{"cube_1"}, list.names());
  EXPECT_EQ(2, done.duplicate);
}

TEST(ObjectList, WhatReplacesAnotherTakesItsPlace) {
  Listing list;
  list.repeat(5, {seen("cube", 0.7)});
  list.repeat(10, {seen("sphere", 0.7)});
  EXPECT_EQ(Names{"sphere_1"}, list.names());
}

TEST(ObjectList, ThePoseIsTheMeanOfTheLatestDetections) {
  ObjectListParams params;
  params.min_change_m = 0;
  params.min_change_rad = 0;
  Listing list(params);
  Rng rng(3);
  double squares = 0;
  constexpr int kRounds = 400;
  constexpr double kSigma = 0.004;
  for (int i = 0; i < kRounds; ++i) {
    const double x = 0.7 + rng.normal(0.0, kSigma);
    list.update({seen("cube", x)});
    if (i >= 20) squares += std::pow(list.position().x() - 0.7, 2);
  }
  // An exponential mean with weight w has the variance w / (2 - w) of one sample's: 0.23 sigma for w = 0.1.
  EXPECT_LT(std::sqrt(squares / (kRounds - 20)), 0.35 * kSigma);
}

TEST(ObjectList, ReportsNoChangeForSmallMotions) {
  ObjectListParams params;
  params.min_change_m = 0.005;
  Listing list(params);
  list.repeat(20, {seen("cube", 0.7)});
  for (int i = 0; i < 50; ++i)
    EXPECT_FALSE(list.update({seen("cube", 0.7 + (i % 2 == 0 ? 0.004 : -0.004))}).changed);
  EXPECT_NEAR(0.7, list.position().x(), 1e-12);
  int changed = 0;
  for (int i = 0; i < 50; ++i) changed += list.update({seen("cube", 0.72)}).changed ? 1 : 0;
  EXPECT_GE(changed, 1);
  EXPECT_LE(changed, 4);
  EXPECT_NEAR(0.72, list.position().x(), 0.005);
}

TEST(ObjectList, ABoxLooksTheSameFromFourSides) {
  Listing list;
  const Eigen::Vector3d lengthwise(0.04, 0.08, 0.05);
  const Eigen::Vector3d crosswise(0.08, 0.04, 0.05);
  list.repeat(3, {seen("box", 0.7, 0.0, 0.75, lengthwise)});
  for (int i = 0; i < 30; ++i) {
    const double yaw = i % 3 * M_PI_2;
    const auto& size = i % 3 == 1 ? crosswise : lengthwise;
    EXPECT_FALSE(list.update({seen("box", 0.7, 0.0, 0.75 + yaw, size)}).changed) << i;
  }
  EXPECT_TRUE(list.object().size_m.isApprox(lengthwise, 1e-9));
  EXPECT_TRUE(list.object().world_T_object.isApprox(make_pose({0.7, 0, 0.7}, {0, 0, 0.75}), 1e-9));
}

TEST(ObjectList, FollowsARotation) {
  Listing list;
  list.repeat(10, {seen("cube", 0.7, 0.0, 3.1)});
  list.repeat(60, {seen("cube", 0.7, 0.0, -2.9)});  // by 0.28 rad, across the cut
  const double yaw = std::atan2(list.object().world_T_object(1, 0), list.object().world_T_object(0, 0));
  EXPECT_LT(std::abs(wrap_angle(yaw + 2.9)), 0.091);
}

TEST(ObjectList, AJumpCountsWhenItLasts) {
  Listing list;
  list.repeat(10, {seen("cube", 0.7)});
  EXPECT_FALSE(list.update({seen("cube", 0.76)}).changed);  // beyond half of match_m: one wrong estimate
  list.update({seen("cube", 0.7)});
  EXPECT_NEAR(0.7, list.position().x(), 1e-9);
  EXPECT_FALSE(list.repeat(2, {seen("cube", 0.76)}).changed);
  EXPECT_TRUE(list.update({seen("cube", 0.76)}).changed);
  EXPECT_NEAR(0.76, list.position().x(), 1e-9);  // at once, not by and by
  EXPECT_EQ(Names{"cube_1"}, list.names());
}

TEST(ObjectList, FartherThanTheMatchIsAnotherObject) {
  Listing list;
  list.repeat(3, {seen("cube", 0.7)});
  list.repeat(3, {seen("cube", 0.7 + 0.081)});
  EXPECT_EQ((Names{"cube_1", "cube_2"}), list.names());
}

TEST(ObjectList, AgesOut) {
  ObjectListParams params;
  params.max_age_s = 1.0;
  Listing list(params);
  list.repeat(3, {seen("cube", 0.7), seen("sphere", 0.9)});
  list.repeat(9, {seen("sphere", 0.9)});
  EXPECT_EQ(2u, list.names().size());
  list.repeat(2, {seen("sphere", 0.9)});
  EXPECT_EQ(Names{"sphere_1"}, list.names());
  list.repeat(3, {seen("cube", 0.5), seen("sphere", 0.9)});
  EXPECT_EQ((Names{"sphere_1", "cube_1"}), list.names());
}

TEST(ObjectList, WithoutAnAgeItStays) {
  ObjectListParams params;
  params.max_age_s = 0.0;
  Listing list(params);
  list.repeat(3, {seen("cube", 0.7)});
  list.time_s += 1e5;
  list.repeat(100, {});
  EXPECT_EQ(Names{"cube_1"}, list.names());
}

TEST(ObjectList, AClockThatWentBackStartsTheAgeAnew) {
  ObjectListParams params;
  params.max_age_s = 1.0;
  Listing list(params);
  list.repeat(3, {seen("cube", 0.7)});
  list.time_s = 5.0;
  list.repeat(8, {});
  EXPECT_EQ(Names{"cube_1"}, list.names());
  list.repeat(5, {});
  EXPECT_EQ(Names{}, list.names());
}

TEST(ObjectList, WhatIsRemovedComesBackWhenSeenAgain) {
  Listing list;
  list.repeat(3, {seen("cube", 0.7)});
  list.scene.clear();
  EXPECT_TRUE(list.update({}).changed);
  EXPECT_EQ(Names{}, list.names());
  list.repeat(3, {seen("cube", 0.7)});
  EXPECT_EQ(Names{"cube_1"}, list.names());
}

TEST(ObjectList, AnObjectOfAnotherOwnerIsNeitherDoubledNorMoved) {
  Listing list;
  list.repeat(3, {seen("cube", 0.7)});
  // Somebody puts an object of his own there, under the same name.
  list.known("cube_1").listed = false;
  list.known("cube_1").still = true;
  const auto done = list.repeat(10, {seen("cube", 0.71), seen("cube", 0.9)});
  EXPECT_EQ(1, done.claimed);
  EXPECT_EQ(Names{"cube_2"}, list.names());
  EXPECT_NEAR(0.9, list.position().x(), 1e-9);
}

TEST(ObjectList, WhatAHandHoldsIsLeftAlone) {
  ObjectListParams params;
  params.max_age_s = 1.0;
  Listing list(params);
  list.repeat(3, {seen("cube", 0.7)});
  auto& held = list.known("cube_1");
  held.still = true;
  // The hand carries it away, farther in an image than a match; what is seen lags behind, and is seen in the
  // hand.
  for (int i = 0; i < 30; ++i) {
    auto& known = list.known("cube_1");
    known.world_T_object.translation().x() += 0.05;
    const double x = known.world_T_object.translation().x();
    known.places = {{x + 0.06, 0.0, 0.7}};
    const auto done = list.update({seen("cube", i % 2 == 0 ? x - 0.07 : x + 0.13)});
    EXPECT_EQ(1, done.claimed) << i;
    EXPECT_FALSE(done.changed);
    EXPECT_EQ(Names{"cube_1"}, list.names());
    EXPECT_DOUBLE_EQ(x, list.position().x());
  }
  // Hidden in the hand it does not age.
  for (int i = 0; i < 30; ++i) list.update({});
  EXPECT_EQ(Names{"cube_1"}, list.names());
  // Put down it is where it was put, and moves from there.
  list.known("cube_1").still = false;
  list.known("cube_1").places.clear();
  list.known("cube_1").world_T_object.translation().x() = 1.0;
  list.repeat(3, {seen("cube", 1.02)});
  EXPECT_EQ(Names{"cube_1"}, list.names());
  EXPECT_NEAR(1.02, list.position().x(), 0.005);
}

TEST(ObjectList, ANeighbourOfAHeldObjectIsSeenButNotMoved) {
  ObjectListParams params;
  params.max_age_s = 1.0;
  Listing list(params);
  list.repeat(3, {seen("cube", 0.7), seen("cube", 0.77)});
  list.known("cube_1").still = true;
  const auto done = list.repeat(30, {seen("cube", 0.76)});
  EXPECT_FALSE(done.changed);
  EXPECT_EQ(2u, list.names().size());
  EXPECT_NEAR(0.77, list.position(1).x(), 1e-9);
}

TEST(ObjectList, WhatAHandHoldsMaySeemToBeOfAnotherClass) {
  Listing list;
  list.repeat(3, {seen("cone", 0.7)});
  list.known("cone_1").still = true;
  EXPECT_EQ(0, list.update({seen("sphere", 0.74)}).claimed) << "a standing object is of one class";
  list.known("cone_1").places = {{0.7, 0.0, 0.75}};
  EXPECT_EQ(1, list.repeat(1, {seen("sphere", 0.65)}).claimed);
  list.repeat(10, {seen("cube", 0.9)});
  EXPECT_EQ((Names{"cone_1", "cube_1"}), list.names()) << "far from the gripper it is another object";
}

ObjectDetection ambiguous(ObjectDetection detection) {
  detection.ambiguous = true;
  return detection;
}

TEST(ObjectList, AmbiguousDetectionsMakeNoObjectAndMoveNone) {
  ObjectListParams params;
  params.max_age_s = 1.0;
  Listing list(params);
  EXPECT_EQ(1, list.repeat(10, {ambiguous(seen("cube", 0.7))}).ambiguous);
  EXPECT_TRUE(list.names().empty());
  list.repeat(3, {seen("cube", 0.7)});
  const auto done = list.repeat(30, {ambiguous(seen("cube", 0.76))});
  EXPECT_FALSE(done.changed);
  EXPECT_EQ(0, done.ambiguous);
  EXPECT_EQ(Names{"cube_1"}, list.names()) << "it is there, who knows where";
  EXPECT_NEAR(0.7, list.position().x(), 1e-9);
  list.repeat(20, {ambiguous(seen("cube", 0.9))});
  EXPECT_TRUE(list.names().empty()) << "that was too far to be it";
}

TEST(ObjectList, AAmbiguousDetectionTakesNoPlainOnesObject) {
  Listing list;
  list.repeat(3, {seen("cube", 0.7)});
  const auto done = list.repeat(20, {ambiguous(seen("cube", 0.7)), seen("cube", 0.72)});
  EXPECT_EQ(Names{"cube_1"}, list.names());
  EXPECT_NEAR(0.72, list.position().x(), 0.005);
  EXPECT_EQ(1, done.ambiguous);
}

TEST(ObjectList, MovedBySomebodyItIsLookedForThere) {
  Listing list;
  list.repeat(3, {seen("cube", 0.7)});
  list.known("cube_1").world_T_object = make_pose({0.9, 0, 0.7}, {0.1, 0, 0});
  EXPECT_FALSE(list.update({}).changed);
  EXPECT_TRUE(list.object().world_T_object.isApprox(make_pose({0.9, 0, 0.7}, {0.1, 0, 0})));  // tilt and all
  list.repeat(2, {seen("cube", 0.92)});
  EXPECT_EQ(Names{"cube_1"}, list.names());
  EXPECT_NEAR(0.92, list.position().x(), 0.005);
}

TEST(ObjectList, IsBounded) {
  ObjectListParams params;
  params.max_objects = 4;
  Listing list(params);
  std::vector<ObjectDetection> many;
  for (int i = 0; i < 40; ++i) many.push_back(seen("cube", 0.2 * i));
  EXPECT_EQ(36, list.update(many).no_room);
  const auto done = list.repeat(10, many);
  EXPECT_EQ(4u, list.names().size());
  EXPECT_EQ(4, done.waiting);
  EXPECT_EQ(32, done.no_room);
}

TEST(ObjectList, TheSameDetectionsGiveTheSameObjects) {
  const auto run = [] {
    Listing list;
    Rng rng(11);
    for (int i = 0; i < 200; ++i) {
      std::vector<ObjectDetection> detections;
      for (int k = 0; k < 8; ++k)
        if (rng.uniform(0.0, 1.0) < 0.7)
          detections.push_back(seen(k % 2 == 0 ? "cube" : "cone", 0.1 * k + rng.normal(0.0, 0.02),
                                    rng.normal(0.0, 0.02), rng.uniform(-3.0, 3.0)));
      list.update(detections);
    }
    std::string text;
    for (std::size_t i = 0; i < list.names().size(); ++i) {
      text += list.names()[i] + " ";
      for (int axis = 0; axis < 3; ++axis) text += std::to_string(list.position(i)[axis]) + " ";
    }
    return text;
  };
  EXPECT_FALSE(run().empty());
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace extperfc::arm
