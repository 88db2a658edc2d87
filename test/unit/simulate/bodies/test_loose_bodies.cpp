#include "test/unit/simulate/bodies/bodies_world.hpp"

namespace extperfc::simulate {
namespace {

TEST(LooseBodies, FallWithGravity) {
  WorldSpec world;
  world.bodies = {make_cube("cube", 0.05, {0, 0, 5})};
  const auto bodies = make_bodies(world);
  step(*bodies, 0.5);
  // Semi-implicit Euler falls g h t / 2 farther than the parabola.
  EXPECT_NEAR(bodies->world_T_body(0).translation().z(), 5 - 0.5 * 9.81 * 0.25 - 0.5 * 9.81 * 0.5 * kStep,
              1e-6);
  EXPECT_NEAR(bodies->body_velocity(0).z(), -9.81 * 0.5, 1e-6);
}

TEST(LooseBodies, RestWhereTheyAreSupported) {
  WorldSpec world;
  world.bodies = {make_floor(), make_cube("cube", 0.05, {0, 0, 0.03}),
                  body("cone", Mobility::kLoose, Cone{0.03, 0.08}, make_pose({0.5, 0, 0.05}), 0.1),
                  body("ball", Mobility::kLoose, Sphere{0.03}, make_pose({-0.5, 0, 0.04}), 0.1),
                  body("can", Mobility::kLoose, Cylinder{0.03, 0.1}, make_pose({0, 0.5, 0.06}), 0.1)};
  const auto bodies = make_bodies(world);
  step(*bodies, 3);
  const std::vector<double> heights{0, 0.025, 0.04, 0.03, 0.05};
  for (int i = 1; i < 5; ++i) {
    EXPECT_NEAR(bodies->world_T_body(i).translation().z(), heights[i], 0.0005) << world.bodies[i].name;
    EXPECT_LT(bodies->body_velocity(i).norm(), 1e-9) << world.bodies[i].name;
    EXPECT_NEAR(bodies->world_T_body(i).linear()(2, 2), 1, 1e-4) << world.bodies[i].name;
  }
}

TEST(LooseBodies, StackOfCubesStays) {
  WorldSpec world;
  world.bodies = {make_floor()};
  for (int i = 0; i < 5; ++i)
    world.bodies.push_back(
        make_cube("cube" + std::to_string(i), 0.05, {0.002 * (i % 2), 0, 0.025 + 0.05 * i}));
  const auto bodies = make_bodies(world);
  step(*bodies, 10);
  for (int i = 1; i <= 5; ++i)
    EXPECT_LT((bodies->world_T_body(i).translation() - world.bodies[i].world_T_body.translation()).norm(),
              0.002)
        << "cube " << i;
}

/// Distance that a cube slides down a slope of `degrees` in one second.
double slide(double degrees, double friction) {
  WorldSpec world;
  const Pose slope = make_pose({0, 0, 0}, {0, degrees * M_PI / 180, 0});
  auto plate = body("slope", Mobility::kFixed, box_of(4, 1, 0.1), slope * make_pose({0, 0, -0.05}));
  plate.friction = 1.0;
  auto cube = make_cube("cube", 0.05, {0, 0, 0});
  cube.world_T_body = slope * make_pose({0, 0, 0.0251});
  cube.friction = friction;
  world.bodies = {plate, cube};
  const auto bodies = make_bodies(world);
  step(*bodies, 1);
  return (bodies->world_T_body(1).translation() - cube.world_T_body.translation()).norm();
}

TEST(LooseBodies, FrictionHoldsUpToItsAngle) {
  // tan(26.57 degrees) = 0.5.
  EXPECT_LT(slide(24, 0.5), 0.003);
  EXPECT_GT(slide(29, 0.5), 0.05);
  EXPECT_NEAR(slide(35, 0.5), 0.5 * 9.81 * (std::sin(0.61087) - 0.5 * std::cos(0.61087)), 0.03);
}

TEST(LooseBodies, BallsAndConesComeToRest) {
  WorldSpec world;
  auto cone = body("cone", Mobility::kLoose, Cone{0.03, 0.08}, make_pose({0, 1, 0.04}, {1.4, 0, 0}), 0.1);
  auto ball = body("ball", Mobility::kLoose, Sphere{0.025}, make_pose({0, 0, 0}), 0.05);
  // A slope of 3 cm height that ends on the floor.
  auto slope = body("slope", Mobility::kFixed, box_of(0.4, 0.4, 0.02), make_pose({0, 0, 0.02}, {0, 0.1, 0}));
  ball.world_T_body = make_pose({-0.1, 0, 0.08});
  world.bodies = {make_floor(), slope, ball, cone};
  const auto bodies = make_bodies(world);
  step(*bodies, 2);
  EXPECT_GT(bodies->body_velocity(2).norm(), 0.05) << "the ball does not roll";
  step(*bodies, 10);
  for (int i = 2; i < 4; ++i) {
    EXPECT_LT(bodies->body_velocity(i).norm(), 1e-9) << world.bodies[i].name;
    EXPECT_LT(bodies->world_T_body(i).translation().norm(), 3) << world.bodies[i].name;
  }
}

TEST(LooseBodies, BounceAsTheirRestitutionSays) {
  WorldSpec world;
  auto ball = body("ball", Mobility::kLoose, Sphere{0.03}, make_pose({0, 0, 0.53}), 0.1);
  auto ground = make_floor();
  ground.restitution = 1.0;
  ball.restitution = 0.6;
  world.bodies = {ground, ball};
  const auto bodies = make_bodies(world);
  double top = 0;
  step(*bodies, 0.33);  // it meets the floor after 0.319 s
  for (int i = 0; i < 240; ++i) {
    bodies->step();
    top = std::max(top, bodies->world_T_body(1).translation().z() - 0.03);
  }
  EXPECT_NEAR(top, 0.36 * 0.5, 0.02);
}

TEST(LooseBodies, DoNotTunnel) {
  WorldSpec world;
  world.bodies = {body("board", Mobility::kFixed, box_of(4, 4, 0.02), make_pose({0, 0, 0}))};
  const std::vector<Geometry> shapes{Sphere{0.015}, box_of(0.03, 0.03, 0.03), Cone{0.02, 0.05},
                                     Cylinder{0.015, 0.03}};
  for (int i = 0; i < 36; ++i)
    world.bodies.push_back(
        body("object" + std::to_string(i), Mobility::kLoose, shapes[i % 4],
             make_pose({0.5 * (i % 6) - 1.25, 0.5 * (i / 6) - 1.25, 2.0 + 0.003 * i}, {0.3 * i, 0.7 * i, 0}),
             0.03));
  const auto bodies = make_bodies(world);
  step(*bodies, 1);
  for (int i = 1; i <= 36; ++i)
    EXPECT_GT(bodies->world_T_body(i).translation().z(), 0.01) << world.bodies[i].name;
}

TEST(LooseBodies, MovedOnesFallFromTheirNewPlace) {
  WorldSpec world;
  auto shelf = body("shelf", Mobility::kMovable, box_of(0.4, 0.4, 0.02), make_pose({0, 0, 1}));
  world.bodies = {make_floor(), shelf, make_cube("cube", 0.05, {0, 0, 1.035})};
  const auto bodies = make_bodies(world);
  step(*bodies, 4);  // asleep
  EXPECT_NEAR(bodies->world_T_body(2).translation().z(), 1.035, 0.001);
  ASSERT_TRUE(bodies->move_body(1, make_pose({3, 0, 1})));
  step(*bodies, 2);
  EXPECT_NEAR(bodies->world_T_body(1).translation().x(), 3, 1e-12);
  EXPECT_NEAR(bodies->world_T_body(2).translation().z(), 0.025, 0.001) << "the cube hangs in the air";
  ASSERT_TRUE(bodies->move_body(2, make_pose({3, 0, 1.2})));
  step(*bodies, 2);
  EXPECT_NEAR(bodies->world_T_body(2).translation().z(), 1.035, 0.001);
}

TEST(LooseBodies, PeoplePushThem) {
  WorldSpec world;
  PersonSpec person;
  person.path_m = {{-1, 0}};
  world.people = {person};
  world.bodies = {make_floor(), make_cube("cube", 0.05, {0, 0, 0.025})};
  const auto bodies = make_bodies(world);
  for (int i = 0; i < 480; ++i) {
    bodies->set_person(0, {-1 + 0.5 * i * kStep, 0, 0});
    bodies->step();
  }
  EXPECT_GT(bodies->world_T_body(1).translation().x(), 0.1);
}

TEST(LooseBodies, OriginIsTheirsNotTheCentreOfMass) {
  WorldSpec world;
  // A tall L: two boxes whose common centre of mass is elsewhere.
  BodySpec hook = body("hook", Mobility::kLoose, box_of(0.1, 0.02, 0.02), make_pose({0, 0, 0.01}), 0.2);
  hook.shapes.push_back(shape_of(box_of(0.02, 0.02, 0.06), make_pose({0.04, 0, 0.04})));
  world.bodies = {make_floor(), hook};
  const auto bodies = make_bodies(world);
  EXPECT_LT((bodies->world_T_body(1).matrix() - hook.world_T_body.matrix()).norm(), 1e-12);
  step(*bodies, 1);
  EXPECT_LT((bodies->world_T_body(1).matrix() - hook.world_T_body.matrix()).norm(), 0.003);
}

}  // namespace
}  // namespace extperfc::simulate
