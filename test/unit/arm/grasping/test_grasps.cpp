// Grasps of a parallel hand. The geometry is checked by points of the solids, not by the library's own lines.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "test/unit/arm/grasping/hands.hpp"

namespace extperfc::arm::test {
namespace {

/// Whether a point of the object's frame is inside, or within `margin_m` of it along every face.
bool inside(const Geometry& geometry, const Eigen::Vector3d& p, double margin_m = 0) {
  const double across = p.head<2>().norm();
  if (const auto* box = std::get_if<Box>(&geometry))
    return ((p.cwiseAbs() - box->size_m / 2).array() <= margin_m).all();
  if (const auto* ball = std::get_if<Sphere>(&geometry)) return p.norm() <= ball->radius_m + margin_m;
  if (const auto* cylinder = std::get_if<Cylinder>(&geometry))
    return across <= cylinder->radius_m + margin_m && std::abs(p.z()) <= cylinder->length_m / 2 + margin_m;
  const auto& cone = std::get<Cone>(geometry);
  const double radius = cone.radius_m * (0.5 - p.z() / cone.height_m);
  return std::abs(p.z()) <= cone.height_m / 2 + margin_m && across <= radius + margin_m;
}

/// Points of a box in the tip's frame, its corners and faces included.
void for_points(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                const std::function<void(const Eigen::Vector3d&)>& visit) {
  constexpr int kSteps = 8;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= 2; ++j)
      for (int k = 0; k <= kSteps; ++k) {
        const Eigen::Vector3d fraction(static_cast<double>(i) / kSteps, j / 2.0,
                                       static_cast<double>(k) / kSteps);
        visit(low + fraction.cwiseProduct(high - low));
      }
}

/// Points of both fingers, open by `opening_m`, and of the palm.
void for_hand(const ParallelHand& hand, double opening_m,
              const std::function<void(const Eigen::Vector3d&)>& visit) {
  for_points(hand.palm_low, hand.palm_high, visit);
  for (const FingerPart& part : hand.parts) {
    const double inner = opening_m / 2 + part.inset_m, outer = inner + part.thickness_m;
    for_points({-part.x_half_m, inner, part.z_low_m}, {part.x_half_m, outer, part.z_high_m}, visit);
    for_points({-part.x_half_m, -outer, part.z_low_m}, {part.x_half_m, -inner, part.z_high_m}, visit);
  }
}

GraspObject random_object(Rng& rng) {
  const double width = rng.uniform(0.02, 0.05);
  switch (rng.integer(0, 4)) {
    case 0:
      return cube_on_table(width, rng.uniform(-3, 3));
    case 1:
      return on_table(Sphere{width / 2}, width);
    case 2: {
      const double height = rng.uniform(0.04, 0.16);
      return on_table(Cone{width / 2, height}, height);
    }
    case 3: {
      const double height = rng.uniform(0.02, 0.25);
      return on_table(Cylinder{width / 2, height}, height);
    }
    default: {
      const double height = rng.uniform(0.02, 0.25);
      return on_table(Box{{width, rng.uniform(0.02, 0.2), height}}, height, rng.uniform(-3, 3));
    }
  }
}

TEST(Hand, FromTheRobotsDescription) {
  // By the formula of the description: 2 (slot offset + 0.0095 + position) for the paddles.
  EXPECT_NEAR(left_hand().opening_min_m, 0.0160, 1e-4);
  EXPECT_NEAR(left_hand().opening_max_m, 0.0577, 1e-4);
  EXPECT_NEAR(right_hand().opening_min_m, 0.0065, 1e-4);
  EXPECT_NEAR(right_hand().opening_max_m, 0.0482, 1e-4);
  EXPECT_EQ(left_hand().finger_links.size(), 4U);
  EXPECT_NEAR(left_hand().parts.front().x_half_m, 0.021, 1e-9);
}

TEST(Hand, SaysWhatIsWrong) {
  EXPECT_EQ(hand_of(baxter(), "nowhere", "l_gripper_l_finger_joint").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(hand_of(baxter(), "left_gripper", "left_s0").error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(hand_of(baxter(), "left_gripper", "l_gripper_r_finger_joint").error().code,
            ErrorCode::kInvalidArgument);
}

TEST(Grasps, ThousandRandomObjectsAreBetweenThePadsAndNothingIsInThePath) {
  Rng rng(11);
  int found = 0, asked = 0, failures = 0;
  while (asked < 1000) {
    const GraspObject object = random_object(rng);
    const ParallelHand& hand = asked % 2 == 0 ? left_hand() : right_hand();
    ++asked;
    const auto grasps = generate_grasps(hand, object);
    if (!grasps) continue;
    ++found;
    // The best, the worst, and one between.
    for (const std::size_t i : {std::size_t{0}, grasps->size() / 2, grasps->size() - 1}) {
      const GraspCandidate& grasp = (*grasps)[i];
      const Pose object_T_tip = object.root_T_object.inverse() * grasp.root_T_tip;
      const Pose object_T_pregrasp = object.root_T_object.inverse() * grasp.root_T_pregrasp;
      for (int step = 0; step <= 2; ++step) {
        Pose pose = object_T_tip;
        pose.translation() += step / 2.0 * (object_T_pregrasp.translation() - object_T_tip.translation());
        for_hand(hand, grasp.opening_m, [&](const Eigen::Vector3d& p) {
          if (inside(object.geometry, pose * p)) ++failures;
          if (step == 0 && (grasp.root_T_tip * p).z() < *object.support_z_m) ++failures;
        });
      }
      // Closed to the width that is promised, less what the grid of lines may miss, a pad is in the object.
      int held = 0;
      const FingerPart& pad = hand.parts.front();
      for_points({-pad.x_half_m, -grasp.closed_m / 2 + 0.001, pad.z_low_m},
                 {pad.x_half_m, grasp.closed_m / 2 - 0.001, pad.z_high_m}, [&](const Eigen::Vector3d& p) {
                   if (std::abs(p.y()) > 1e-4 && inside(object.geometry, object_T_tip * p, 1e-3)) ++held;
                 });
      EXPECT_GT(held, 0) << asked;
    }
  }
  EXPECT_EQ(failures, 0);
  EXPECT_GT(found, 700);
}

TEST(Grasps, BestOfACubeIsFromAboveSquareToItsFaces) {
  for (const double yaw : {0.0, 0.3, -1.0}) {
    const GraspObject cube = cube_on_table(0.04, yaw);
    const auto grasps = generate_grasps(left_hand(), cube);
    ASSERT_TRUE(grasps) << grasps.error().message;
    const GraspCandidate& best = grasps->front();
    EXPECT_NEAR(best.approach.z(), -1, 1e-9);
    const Eigen::Vector3d closing = cube.root_T_object.linear().transpose() * best.root_T_tip.linear().col(1);
    EXPECT_NEAR(closing.cwiseAbs().maxCoeff(), 1, 1e-9);
    EXPECT_NEAR(best.closed_m, 0.04, 1e-9);
    EXPECT_NEAR(best.opening_m, 0.044, 1e-9);
    EXPECT_EQ(best.lean_rad, 0);
  }
}

TEST(Grasps, InvariantsOfEveryCandidate) {
  for (const GraspObject& object :
       {cube_on_table(0.04, 0.5), on_table(Sphere{0.025}, 0.05), on_table(Cylinder{0.02, 0.15}, 0.15),
        on_table(Cone{0.025, 0.1}, 0.1), on_table(Box{{0.03, 0.1, 0.2}}, 0.2, 0.2)}) {
    const auto grasps = generate_grasps(left_hand(), object);
    ASSERT_TRUE(grasps) << grasps.error().message;
    for (std::size_t i = 0; i < grasps->size(); ++i) {
      const GraspCandidate& grasp = (*grasps)[i];
      EXPECT_GT(grasp.score, 0);
      EXPECT_LE(grasp.score, 1);
      if (i > 0) {
        EXPECT_LE(grasp.score, (*grasps)[i - 1].score);
      }
      EXPECT_TRUE(grasp.root_T_tip.linear().isUnitary(1e-9));
      EXPECT_NEAR(grasp.root_T_tip.linear().determinant(), 1, 1e-9);
      EXPECT_TRUE(grasp.approach.isApprox(grasp.root_T_tip.linear().col(2), 1e-12));
      EXPECT_TRUE((grasp.root_T_pregrasp.translation() + grasp.approach_m * grasp.approach)
                      .isApprox(grasp.root_T_tip.translation(), 1e-9));
      EXPECT_TRUE((grasp.root_T_tip * grasp.tip_T_object).isApprox(object.root_T_object, 1e-9));
      EXPECT_GE(grasp.support_gap_m, 0.005 - 1e-9);
      // The same hand turned by half a revolution is a candidate too.
      const bool twin = std::any_of(grasps->begin(), grasps->end(), [&](const GraspCandidate& other) {
        return other.root_T_tip.translation().isApprox(grasp.root_T_tip.translation(), 1e-9) &&
               other.approach.isApprox(grasp.approach, 1e-9) &&
               other.root_T_tip.linear().col(1).isApprox(-grasp.root_T_tip.linear().col(1), 1e-9);
      });
      EXPECT_TRUE(twin);
    }
  }
}

TEST(Grasps, RotateWithTheObject) {
  const GraspObject one = cube_on_table(0.035, 0.2);
  GraspObject two = one;
  const Pose rotation = make_pose({0.1, -0.5, 0}, {0, 0, 0.9});
  two.root_T_object = rotation * one.root_T_object;
  const auto first = generate_grasps(left_hand(), one), second = generate_grasps(left_hand(), two);
  ASSERT_TRUE(first && second);
  ASSERT_EQ(first->size(), second->size());
  for (const GraspCandidate& grasp : *first)
    EXPECT_TRUE(std::any_of(second->begin(), second->end(), [&](const GraspCandidate& other) {
      return other.root_T_tip.isApprox(rotation * grasp.root_T_tip, 1e-9) &&
             std::abs(other.score - grasp.score) < 1e-9;
    }));
}

TEST(Grasps, Deterministic) {
  const GraspObject object = on_table(Cylinder{0.02, 0.12}, 0.12);
  const auto first = generate_grasps(left_hand(), object), second = generate_grasps(left_hand(), object);
  ASSERT_TRUE(first && second);
  ASSERT_EQ(first->size(), second->size());
  for (std::size_t i = 0; i < first->size(); ++i)
    EXPECT_EQ((*first)[i].root_T_tip.matrix(), (*second)[i].root_T_tip.matrix());
}

TEST(Grasps, BoundedCount) {
  GraspParams params;
  params.max_candidates = 7;
  const auto grasps = generate_grasps(left_hand(), on_table(Sphere{0.02}, 0.04), params);
  ASSERT_TRUE(grasps);
  EXPECT_EQ(grasps->size(), 7U);
}

TEST(Grasps, TooWideSaysWidthAndOpening) {
  const auto grasps = generate_grasps(left_hand(), cube_on_table(0.07));
  ASSERT_FALSE(grasps);
  EXPECT_EQ(grasps.error().code, ErrorCode::kFailed);
  EXPECT_NE(grasps.error().message.find("70.0 mm"), std::string::npos) << grasps.error().message;
  EXPECT_NE(grasps.error().message.find("57.7 mm"), std::string::npos) << grasps.error().message;
}

TEST(Grasps, TooThinForFingersThatDoNotMeet) {
  EXPECT_FALSE(generate_grasps(left_hand(), on_table(Cylinder{0.006, 0.1}, 0.1)));
  EXPECT_TRUE(generate_grasps(right_hand(), on_table(Cylinder{0.006, 0.1}, 0.1)));
}

TEST(Grasps, UncertaintyWidensTheOpeningUntilItIsTooMuch) {
  GraspObject cube = cube_on_table(0.04);
  cube.covariance = Eigen::Vector3d(9e-6, 9e-6, 1e-6).asDiagonal();  // 3 mm
  const auto grasps = generate_grasps(left_hand(), cube);
  ASSERT_TRUE(grasps) << grasps.error().message;
  EXPECT_NEAR(grasps->front().opening_m, 0.04 + 2 * (0.002 + 2 * 0.003), 1e-9);
  EXPECT_LT(grasps->front().score, generate_grasps(left_hand(), cube_on_table(0.04))->front().score);
  cube.covariance *= 9;
  const auto none = generate_grasps(left_hand(), cube);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("uncertain"), std::string::npos) << none.error().message;
}

TEST(Grasps, UncertaintyInOneDirectionRotatesTheGripper) {
  GraspObject cube = cube_on_table(0.04);
  cube.covariance = Eigen::Vector3d(1e-4, 1e-8, 1e-8).asDiagonal();  // 1 cm along x
  const auto grasps = generate_grasps(left_hand(), cube);
  ASSERT_TRUE(grasps) << grasps.error().message;
  for (const GraspCandidate& grasp : *grasps) EXPECT_NEAR(std::abs(grasp.root_T_tip.linear()(1, 1)), 1, 1e-9);
}

TEST(Grasps, ConeHoldsOnlyWhereFrictionDoes) {
  // tan of the half-angle is 0.25; the lean is the half-angle.
  GraspParams params;
  params.friction_ratio = 1;
  params.friction = 0.26;
  const GraspObject cone = on_table(Cone{0.025, 0.1}, 0.1);
  const auto grasps = generate_grasps(left_hand(), cone, params);
  ASSERT_TRUE(grasps) << grasps.error().message;
  const GraspCandidate& best = grasps->front();
  EXPECT_NEAR(best.lean_rad, std::atan(0.25), 1e-6);
  // Its lowest edge is the contact: the width is that of the cone at this height.
  const double low = best.root_T_tip.translation().z() - left_hand().parts[0].z_high_m - 0.1;
  if (best.approach.z() < -0.999) {
    EXPECT_NEAR(best.closed_m, 2 * 0.025 * (1 - low / 0.1), 5e-4);
  }
  params.friction = 0.24;
  const auto none = generate_grasps(left_hand(), cone, params);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("leans by at least 14 degrees"), std::string::npos)
      << none.error().message;
}

TEST(Grasps, ConeOnNothingIsHeldAtItsRim) {
  GraspParams params;
  params.friction = 0.1;
  GraspObject cone = on_table(Cone{0.025, 0.08}, 0.08);
  cone.support_z_m.reset();
  const auto grasps = generate_grasps(left_hand(), cone, params);
  ASSERT_TRUE(grasps) << grasps.error().message;
  EXPECT_EQ(grasps->front().lean_rad, 0);
  EXPECT_NEAR(grasps->front().closed_m, 0.05, 1e-9);
}

TEST(Grasps, TallObjectsAreHeldBelowThePalm) {
  const GraspObject tall = on_table(Box{{0.04, 0.04, 0.3}}, 0.3);
  const auto grasps = generate_grasps(left_hand(), tall);
  ASSERT_TRUE(grasps) << grasps.error().message;
  bool top = false, side = false;
  for (const GraspCandidate& grasp : *grasps) {
    top = top || grasp.approach.z() < -0.999;
    side = side || std::abs(grasp.approach.z()) < 1e-4;
    if (grasp.approach.z() < -0.999) {
      EXPECT_GE(grasp.root_T_tip.translation().z() + -left_hand().palm_high.z(), 0.4 + 0.005 - 1e-9);
    }
  }
  EXPECT_TRUE(top);
  EXPECT_TRUE(side);
}

TEST(Grasps, BadInputIsNamed) {
  const auto code = [](const GraspObject& object, const GraspParams& params = {}) {
    const auto grasps = generate_grasps(left_hand(), object, params);
    return grasps ? ErrorCode::kNotFound : grasps.error().code;
  };
  GraspObject object = cube_on_table(0.04);
  object.geometry = TriangleMesh{};
  EXPECT_EQ(code(object), ErrorCode::kUnsupported);
  object = cube_on_table(0.04);
  object.root_T_object.translation().x() = std::nan("");
  EXPECT_EQ(code(object), ErrorCode::kInvalidArgument);
  object = cube_on_table(0.04);
  object.covariance(0, 1) = 0.1;
  EXPECT_EQ(code(object), ErrorCode::kInvalidArgument);
  object = cube_on_table(0.04);
  object.support_z_m = std::numeric_limits<double>::infinity();
  EXPECT_EQ(code(object), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code(on_table(Sphere{-1}, 0.1)), ErrorCode::kInvalidArgument);
  GraspParams params;
  params.friction = 0;
  EXPECT_EQ(code(cube_on_table(0.04), params), ErrorCode::kInvalidArgument);
}

TEST(Places, InverseOfPicking) {
  const GraspObject cube = cube_on_table(0.04, 0.7);
  const auto grasps = generate_grasps(left_hand(), cube);
  ASSERT_TRUE(grasps);
  for (const GraspCandidate& grasp : *grasps) {
    const auto places = place_poses(
        left_hand(), {grasp.tip_T_object, cube.root_T_object, false, grasp.opening_m, cube.support_z_m});
    ASSERT_TRUE(places) << places.error().message;
    ASSERT_EQ(places->size(), 1U);
    EXPECT_TRUE(places->front().root_T_tip.isApprox(grasp.root_T_tip, 1e-9));
    EXPECT_TRUE(places->front().root_T_retreat.isApprox(grasp.root_T_pregrasp, 1e-9));
    EXPECT_NEAR(places->front().root_T_above.translation().z() - grasp.root_T_tip.translation().z(), 0.1,
                1e-12);
  }
}

TEST(Places, AnyYawKeepsTheObjectStandingWhereItShall) {
  const GraspCandidate grasp = generate_grasps(left_hand(), cube_on_table(0.04))->front();
  PlaceRequest request{grasp.tip_T_object, make_pose({0.5, -0.2, 0.42}, {0, 0, 1}), true, 0.05, 0.4};
  const auto places = place_poses(left_hand(), request);
  ASSERT_TRUE(places) << places.error().message;
  EXPECT_EQ(places->size(), 16U);
  for (std::size_t i = 0; i < places->size(); ++i) {
    const PlaceCandidate& place = (*places)[i];
    if (i > 0) {
      EXPECT_GE(std::abs(place.yaw_rad), std::abs((*places)[i - 1].yaw_rad) - 1e-12);
    }
    EXPECT_TRUE((place.root_T_tip * grasp.tip_T_object).isApprox(place.root_T_object, 1e-9));
    EXPECT_TRUE(place.root_T_object.translation().isApprox(request.root_T_object.translation(), 1e-12));
    EXPECT_NEAR(place.root_T_object.linear()(2, 2), 1, 1e-12);
  }
}

TEST(Places, RefusesWhatCannotBe) {
  const GraspCandidate grasp = generate_grasps(left_hand(), cube_on_table(0.04))->front();
  PlaceRequest request{grasp.tip_T_object, make_pose({0.5, -0.2, 0.42}), false, 0.05, 0.4};
  request.root_T_object = make_pose({0.5, 0, 0.4}, {3.14159, 0, 0});  // upside down: the hand is below
  EXPECT_EQ(place_poses(left_hand(), request).error().code, ErrorCode::kFailed);
  request.root_T_object = make_pose({0.5, 0, std::nan("")});
  EXPECT_EQ(place_poses(left_hand(), request).error().code, ErrorCode::kInvalidArgument);
  request.root_T_object = make_pose({0.5, 0, 0.42});
  request.opening_m = 0.2;
  EXPECT_EQ(place_poses(left_hand(), request).error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace extperfc::arm::test
