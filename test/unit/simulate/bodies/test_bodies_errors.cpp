#include <cstdio>
#include <fstream>
#include <limits>

#include "test/unit/simulate/bodies/bodies_world.hpp"

namespace extperfc::simulate {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string error_of(const WorldSpec& world, const BodiesParams& params = {}) {
  const auto bodies = Bodies::make(params, no_robot(), world, Pose::Identity(), {});
  return bodies ? "" : bodies.error().message;
}

std::string error_of(const BodySpec& spec) {
  WorldSpec world;
  world.bodies = {spec};
  return error_of(world);
}

BodiesParams with_step(double step_s) {
  BodiesParams params;
  params.step_s = step_s;
  return params;
}

TEST(BodiesErrors, ParametersOutOfRange) {
  EXPECT_EQ(error_of(WorldSpec{}), "");
  for (const double step_s : {0.0, -0.01, 0.011, kNaN})
    EXPECT_NE(error_of(WorldSpec{}, with_step(step_s)).find("step_s"), std::string::npos) << step_s;
  BodiesParams params;
  params.solver_iterations = 9;
  EXPECT_NE(error_of(WorldSpec{}, params).find("solver_iterations"), std::string::npos);
  params = {};
  params.gravity_m_s2 = kNaN;
  EXPECT_NE(error_of(WorldSpec{}, params).find("gravity_m_s2"), std::string::npos);
}

TEST(BodiesErrors, LooseBodyWithoutMassOrShape) {
  auto cube = make_cube("my cube", 0.05, {0, 0, 0});
  EXPECT_EQ(error_of(cube), "");
  for (const double mass : {0.0, -1.0, kNaN, std::numeric_limits<double>::infinity()}) {
    cube.mass_kg = mass;
    const auto message = error_of(cube);
    EXPECT_NE(message.find("my cube"), std::string::npos) << mass;
    EXPECT_NE(message.find("mass_kg"), std::string::npos) << mass;
  }
  cube.mass_kg = 1;
  cube.shapes.clear();
  EXPECT_NE(error_of(cube).find("shape"), std::string::npos);
}

TEST(BodiesErrors, ShapesThatCannotBe) {
  const std::vector<Geometry> bad{
      box_of(0, 1, 1), box_of(kNaN, 1, 1),          Sphere{0}, Sphere{-1}, Cylinder{0.1, 0},
      Cone{kNaN, 0.1}, TriangleMesh{"/no/mesh.stl"}};
  for (const auto& geometry : bad)
    EXPECT_NE(error_of(body("object", Mobility::kFixed, geometry, Pose::Identity())), "") << geometry.index();
}

TEST(BodiesErrors, PosesAndCoefficientsThatAreNotNumbers) {
  auto cube = make_cube("cube", 0.05, {0, kNaN, 0});
  EXPECT_NE(error_of(cube).find("pose"), std::string::npos);
  cube = make_cube("cube", 0.05, {0, 0, 0});
  cube.friction = -1;
  EXPECT_NE(error_of(cube).find("friction"), std::string::npos);
  cube.friction = 1;
  cube.restitution = 1.5;
  EXPECT_NE(error_of(cube).find("restitution"), std::string::npos);
  cube.restitution = 0;
  cube.shapes[0].body_T_shape.translation().x() = kNaN;
  EXPECT_NE(error_of(cube).find("shape"), std::string::npos);
}

TEST(BodiesErrors, StartPositionsMustFitTheRobot) {
  const auto bodies = Bodies::make({}, no_robot(), {}, Pose::Identity(), {0.0, 1.0});
  ASSERT_FALSE(bodies);
  EXPECT_NE(bodies.error().message.find("2 values for 0 joints"), std::string::npos)
      << bodies.error().message;
}

TEST(BodiesErrors, FixedBodiesDoNotMove) {
  WorldSpec world;
  world.bodies = {make_floor(), make_cube("cube", 0.05, {0, 0, 0.025})};
  const auto bodies = make_bodies(world);
  EXPECT_FALSE(bodies->move_body(0, Pose::Identity()));
  EXPECT_FALSE(bodies->move_body(7, Pose::Identity()));
  EXPECT_FALSE(bodies->move_body(-1, Pose::Identity()));
  EXPECT_FALSE(bodies->move_body(1, make_pose({kNaN, 0, 0})));
  EXPECT_TRUE(bodies->move_body(1, make_pose({1, 0, 0.025})));
}

/// A file of one triangle's bytes: header, count, normal, corners, attribute.
class MeshOnDisk {
 public:
  MeshOnDisk(const std::string& name, std::uint32_t said, const std::vector<std::array<float, 9>>& triangles)
      : path_(::testing::TempDir() + name) {
    std::ofstream file(path_, std::ios::binary);
    file << std::string(80, ' ');
    file.write(reinterpret_cast<const char*>(&said), sizeof(said));
    for (const auto& triangle : triangles) {
      file << std::string(12, '\0');
      file.write(reinterpret_cast<const char*>(triangle.data()), sizeof(triangle));
      file << std::string(2, '\0');
    }
  }
  ~MeshOnDisk() { std::remove(path_.c_str()); }
  MeshOnDisk(const MeshOnDisk&) = delete;
  MeshOnDisk& operator=(const MeshOnDisk&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

TEST(BodiesErrors, DamagedMeshesAreNamed) {
  const auto message = [](const MeshOnDisk& mesh) {
    return error_of(body("object", Mobility::kFixed, TriangleMesh{mesh.path()}, Pose::Identity()));
  };
  const MeshOnDisk empty("empty.stl", 0, {});
  EXPECT_NE(message(empty).find("empty.stl"), std::string::npos);
  const MeshOnDisk cut("cut.stl", 5, {{0, 0, 0, 1, 0, 0, 0, 1, 0}});
  EXPECT_NE(message(cut).find("does not fit"), std::string::npos);
  const MeshOnDisk nan("nan.stl", 1, {{0, 0, 0, 1, 0, 0, 0, static_cast<float>(kNaN), 0}});
  EXPECT_NE(message(nan).find("not finite"), std::string::npos);
}

TEST(BodiesErrors, MeshCountsAsItsHull) {
  // A pyramid of 10 cm, scaled to 20 cm, with a flat bottom.
  const MeshOnDisk pyramid("pyramid.stl", 4,
                           {{0, 0, 1, 1, 0, 0, 0, 1, 0},
                            {0, 0, 1, 0, 1, 0, -1, 0, 0},
                            {0, 0, 1, -1, 0, 0, 0, -1, 0},
                            {0, 0, 1, 0, -1, 0, 1, 0, 0}});
  WorldSpec world;
  world.bodies = {make_floor(),
                  body("pyramid", Mobility::kLoose, TriangleMesh{pyramid.path(), {0.1, 0.1, 0.1}},
                       make_pose({0, 0, 0.01}), 0.3)};
  const auto bodies = make_bodies(world);
  step(*bodies, 2);
  EXPECT_NEAR(bodies->world_T_body(1).translation().z(), 0, 0.001);
  EXPECT_NEAR(bodies->world_T_body(1).linear()(2, 2), 1, 1e-3);
}

}  // namespace
}  // namespace extperfc::simulate
