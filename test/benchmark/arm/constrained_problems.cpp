#include "test/benchmark/arm/constrained_problems.hpp"

#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "extperfc/arm/srdf.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::benchmark {

namespace {

const std::filesystem::path kRoot = EXTPERFC_SOURCE_DIR;
constexpr double kTableTopM = -0.05;  // in Baxter's `base`
constexpr double kMinDistanceM = 0.3;

struct LevelArm {
  arm::CollisionModel model;
  arm::PathConstraint constraint;
  Pose root_T_base{Pose::Identity()};
};

Result<LevelArm> load_arm() {
  const auto robot = RobotModel::from_file(kRoot / "urdf/mobile_baxter.urdf", kRoot);
  if (!robot) return tl::unexpected(robot.error());
  const auto srdf = arm::read_srdf(kRoot / "config/robots/baxter/mobile_baxter.srdf");
  if (!srdf) return tl::unexpected(srdf.error());
  const auto joints = arm::joints_of_group(*srdf, *robot, "left_arm");
  if (!joints) return tl::unexpected(joints.error());
  arm::CollisionModelParams params;
  params.joints = *joints;
  params.allowed = arm::allowed_pairs(*srdf);
  for (const auto& state : srdf->states)
    if (state.name == "neutral" && state.group == "right_arm") params.fixed_positions = state.positions;
  auto model = arm::CollisionModel::make(*robot, params);
  if (!model) return tl::unexpected(model.error());
  arm::PathConstraintParams level;
  level.joints = *joints;
  Pose down = Pose::Identity();
  down.linear() = Eigen::DiagonalMatrix<double, 3>(1.0, -1.0, -1.0);
  level.constraints.push_back(
      {arm::ToolConstraintKind::kKeepAxis, kTool, "", Eigen::Vector3d::UnitZ(), down});
  auto constraint = arm::PathConstraint::make(*robot, level);
  if (!constraint) return tl::unexpected(constraint.error());
  const Pose root_T_base = *model->link_pose(arm::JointVector::Zero(model->joint_count()), "base");
  return LevelArm{*std::move(model), *std::move(constraint), root_T_base};
}

/// `centre_m` in Baxter's `base`.
Result<void> add_box(arm::CollisionWorld* world, const LevelArm& arm, const std::string& name,
                     const Eigen::Vector3d& centre_m, const Eigen::Vector3d& size_m, double yaw_rad) {
  arm::WorldObject object;
  object.name = name;
  object.shapes.push_back({Box{size_m}, Pose::Identity(), {}});
  object.root_T_object = arm.root_T_base * make_pose(centre_m, {0, 0, yaw_rad});
  return world->add(object);
}

Result<arm::CollisionWorld> random_table(const LevelArm& arm, Rng& rng) {
  arm::CollisionWorld world;
  if (auto added = add_box(&world, arm, "table", {0.85, 0.35, kTableTopM - 0.02}, {0.8, 1.5, 0.04}, 0.0);
      !added)
    return tl::unexpected(added.error());
  const int boxes = rng.integer(3, 6);
  for (int i = 0; i < boxes; ++i) {
    const Eigen::Vector3d size(rng.uniform(0.06, 0.25), rng.uniform(0.06, 0.25), rng.uniform(0.1, 0.45));
    const Eigen::Vector3d centre(rng.uniform(0.5, 1.15), rng.uniform(-0.25, 0.95),
                                 kTableTopM + 0.5 * size.z());
    const double yaw = rng.uniform(0.0, 1.57);
    if (auto added = add_box(&world, arm, "box_" + std::to_string(i), centre, size, yaw); !added)
      return tl::unexpected(added.error());
  }
  return world;
}

std::optional<arm::JointVector> random_level_state(const LevelArm& arm, arm::CollisionChecker& exact,
                                                   Rng& rng) {
  const auto& limits = arm.model.limits();
  arm::JointVector state(limits.lower.size());
  for (Eigen::Index j = 0; j < state.size(); ++j) state[j] = rng.uniform(limits.lower[j], limits.upper[j]);
  const auto level = arm.constraint.project(state, limits);
  if (!level || exact.contact(*level)) return std::nullopt;
  const Eigen::Vector3d at = (arm.root_T_base.inverse() * *arm.model.link_pose(*level, kTool)).translation();
  const bool over = at.x() > 0.45 && at.x() < 1.2 && at.y() > -0.35 && at.y() < 1.05 && at.z() > kTableTopM &&
                    at.z() < kTableTopM + 0.55;
  if (!over) return std::nullopt;
  return level;
}

}  // namespace

double tilt_rad(const arm::CollisionModel& model, const arm::JointVector& joints) {
  const Eigen::Vector3d axis = model.link_pose(joints, kTool)->linear().col(2);
  return std::atan2(axis.head<2>().norm(), -axis.z());
}

Result<std::vector<LevelProblem>> level_problems(std::uint64_t seed, int count) {
  const auto arm = load_arm();
  if (!arm) return tl::unexpected(arm.error());
  Rng rng(seed);
  std::vector<LevelProblem> problems;
  while (static_cast<int>(problems.size()) < count) {
    auto world = random_table(*arm, rng);
    if (!world) return tl::unexpected(world.error());
    auto exact = arm::CollisionChecker::make(arm->model, *world, {1e-3, false});
    if (!exact) return tl::unexpected(exact.error());
    std::vector<arm::JointVector> ends;
    const auto place = [&](const arm::JointVector& joints) {
      return Eigen::Vector3d(arm->model.link_pose(joints, kTool)->translation());
    };
    while (ends.size() < 2) {
      const auto state = random_level_state(*arm, *exact, rng);
      if (!state || (!ends.empty() && (place(*state) - place(ends[0])).norm() < kMinDistanceM)) continue;
      ends.push_back(*state);
    }
    problems.push_back({arm->model, *std::move(world), arm->constraint, ends[0], ends[1]});
  }
  return problems;
}

}  // namespace extperfc::benchmark
