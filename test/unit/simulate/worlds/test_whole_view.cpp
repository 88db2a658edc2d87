#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"

#include "simulate/render_tool/ray_shape.hpp"
#include "simulate/render_tool/whole_view.hpp"

namespace extperfc::simulate {
namespace {
const CameraModel kCamera{640, 480, 600, 600, 319.5, 239.5, {}};

/// A body whose only shape stands at this pose in the optical frame, which is the world's.
BodySpec body_of(const Geometry& geometry, const Pose& pose) {
  BodySpec body;
  body.world_T_body = pose;
  body.shapes.push_back({geometry, Pose::Identity(), {}});
  return body;
}

WholeView view_of(const Geometry& geometry, const Pose& pose) {
  return whole_view(body_of(geometry, pose), kCamera, Pose::Identity());
}

/// The discretisation errs by about the outline's length times the step, half a pixel deep.
void expect_pixels(const WholeView& view, double pixels) {
  EXPECT_NEAR(view.pixels, pixels, 0.03 * pixels + 4);
}

TEST(WholeView, AreasAreThoseOfTheProjection) {
  // A sphere on the axis: a disc of radius f r / sqrt(z^2 - r^2).
  const double radius = 600 * 0.05 / std::sqrt(1 - 0.05 * 0.05);
  expect_pixels(view_of(Sphere{0.05}, make_pose({0, 0, 1})), kPi * radius * radius);
  // The front face of a box hides the rest.
  expect_pixels(view_of(Box{{0.1, 0.06, 0.02}}, make_pose({0, 0, 1.01})), 60.0 * 36);
  // A cylinder whose round face looks at the camera.
  expect_pixels(view_of(Cylinder{0.04, 0.02}, make_pose({0, 0, 1.01})), kPi * 24 * 24);
  // A cone from its base, and from the side far away: a triangle.
  expect_pixels(view_of(Cone{0.04, 0.1}, make_pose({0, 0, 1.05})), kPi * 24 * 24);
  expect_pixels(view_of(Cone{0.1, 1.0}, make_pose({0, 0, 10}, {kPi / 2, 0, 0})), 60.0 * 12 / 2);
}

TEST(WholeView, CountsWhatLiesInsideTheImage) {
  const WholeView inside = view_of(Sphere{0.05}, make_pose({0, 0, 1}));
  EXPECT_DOUBLE_EQ(inside.pixels, inside.pixels_inside);
  const double half_out = -320.0 / 600;  // the left border
  const WholeView half = view_of(Box{{0.1, 0.1, 0.001}}, make_pose({half_out, 0, 1}));
  EXPECT_NEAR(half.pixels_inside / half.pixels, 0.5, 0.03);
  const WholeView outside = view_of(Box{{0.1, 0.1, 0.001}}, make_pose({-2, 0, 1}));
  EXPECT_GT(outside.pixels, 3000);
  EXPECT_EQ(outside.pixels_inside, 0);
}

TEST(WholeView, LargeBodiesAreSampled) {
  const WholeView view = view_of(Box{{2, 2, 0.01}}, make_pose({0, 0, 1.005}));
  EXPECT_NEAR(view.pixels, 1200.0 * 1200, 0.06 * 1200 * 1200);
  EXPECT_NEAR(view.pixels_inside, 640.0 * 480, 0.1 * 640 * 480);
}

TEST(WholeView, BodiesBehindTheCameraAreNotSeen) {
  EXPECT_EQ(view_of(Sphere{0.1}, make_pose({0, 0, -1})).pixels, 0);
  EXPECT_EQ(view_of(Box{{0.1, 0.1, 0.1}}, make_pose({0, 0.4, -0.3})).pixels, 0);
}

TEST(RayShape, ConesHaveOneTip) {
  const Cone cone{0.5, 1};
  const Eigen::Vector3d sideways(1, 0, 0);
  EXPECT_TRUE(meets({{-5, 0, 0}, sideways}, cone));
  EXPECT_TRUE(meets({{-5, 0, 0.49}, sideways}, cone));
  EXPECT_FALSE(meets({{-5, 0, 0.51}, sideways}, cone)) << "above the tip";
  EXPECT_FALSE(meets({{-5, 0.3, 0}, sideways}, cone)) << "beside it at half height";
  EXPECT_TRUE(meets({{-5, 0.3, -0.4}, sideways}, cone));
  EXPECT_FALSE(meets({{5, 0, 0}, sideways}, cone)) << "behind the ray's start";
  EXPECT_TRUE(meets({{0.2, 0, 5}, {0, 0, -1}}, cone));
  EXPECT_FALSE(meets({{0.51, 0, 5}, {0, 0, -1}}, cone));
}

/// Every ray from outside towards a point within must meet the shape; rays that miss the bounding sphere must
/// not.
TEST(RayShape, RaysTowardsTheInsideMeet) {
  const std::vector<Geometry> shapes{Box{{0.2, 0.3, 0.4}}, Cylinder{0.2, 0.5}, Sphere{0.3}, Cone{0.3, 0.5}};
  for (const Geometry& shape : shapes)
    for (int i = 0; i < 500; ++i) {
      const double yaw = 0.37 * i;
      const double rise = std::sin(1.7 * i);
      const Eigen::Vector3d away(std::cos(yaw) * std::cos(rise), std::sin(yaw) * std::cos(rise),
                                 std::sin(rise));
      const Eigen::Vector3d within(0, 0, -0.1 + 0.05 * std::sin(3.1 * i));
      EXPECT_TRUE(meets({3 * away, within - 3 * away}, shape)) << i;
      const Eigen::Vector3d side = away.unitOrthogonal();
      EXPECT_FALSE(meets({3 * away + 1.01 * bounding_radius_m(shape) * side, -away}, shape)) << i;
    }
}

}  // namespace
}  // namespace extperfc::simulate
