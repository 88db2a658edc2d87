#include "extperfc/simulate/bodies.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "simulate/bodies/chassis.hpp"
#include "simulate/bodies/dynamic_robot.hpp"
#include "simulate/bodies/grips.hpp"
#include "simulate/bodies/kinematic_robot.hpp"
#include "simulate/bodies/scenery.hpp"

namespace extperfc::simulate {
namespace {

/// A root that would have to be faster than this was put elsewhere [m/s], [rad/s].
constexpr double kJumpSpeed = 5.0;
constexpr double kJumpRotation = 10.0;

Result<void> check(const BodiesParams& params, const RobotModel& robot, const Pose& world_T_root,
                   const std::vector<double>& start) {
  const auto bad = [](const std::string& what) {
    return fail(ErrorCode::kInvalidArgument, "bodies: " + what);
  };
  if (!(params.step_s > 0 && params.step_s <= 0.01)) return bad("step_s must be above 0 and at most 0.01 s");
  if (params.solver_iterations < 10 || params.solver_iterations > 500)
    return bad("solver_iterations must be from 10 to 500");
  if (!(params.gravity_m_s2 >= 0 && params.gravity_m_s2 <= 20))
    return bad("gravity_m_s2 must be from 0 to 20 m/s^2");
  if (robot.links().empty()) return bad("the robot has no link: load its description first");
  if (!world_T_root.matrix().allFinite()) return bad("the robot's pose is not finite: check its numbers");
  if (start.size() != robot.joints().size())
    return bad("start positions: " + std::to_string(start.size()) + " values for " +
               std::to_string(robot.joints().size()) + " joints: give one for each");
  for (std::size_t i = 0; i < start.size(); ++i)
    if (!std::isfinite(start[i]))
      return bad("start position of " + robot.joints()[i].name + " is not finite");
  return {};
}

/// Bodies in Bullet's world.
class BulletBodies : public Bodies {
 public:
  BulletBodies(const BodiesParams& params, const RobotModel& robot, const Pose& world_T_root)
      : params_(params),
        model_(robot),
        world_(params),
        world_T_root_(world_T_root),
        next_root_(world_T_root) {
    plan_.model = &model_;
    plan_.tree = make_rigid_tree(model_);
    plan_.grippers = find_grippers(model_, plan_.tree);
  }

  Result<void> build(const WorldSpec& spec, const std::vector<double>& start);

  void set_root(const Pose& world_T_root) override;
  [[nodiscard]] bool root_collides(const Pose& world_T_root) override {
    return chassis_->collides(world_T_root);
  }
  void set_target(int joint, const JointTarget& target) override { robot_->set_target(joint, target); }
  void step() override;

  [[nodiscard]] double position(int joint) const override { return robot_->positions()[joint]; }
  [[nodiscard]] double velocity(int joint) const override { return robot_->velocities()[joint]; }
  [[nodiscard]] double effort(int joint) const override {
    return params_.dynamic ? robot_->motor_effort(joint) : gravity_efforts_[joint];
  }
  [[nodiscard]] std::vector<double> gravity_efforts() const override { return gravity_efforts_; }
  [[nodiscard]] Pose world_T_link(int link) const override { return world_T_link_[link]; }
  [[nodiscard]] Pose world_T_body(int body) const override { return scenery_->world_T_body(body); }
  [[nodiscard]] Eigen::Vector3d body_velocity(int body) const override { return scenery_->velocity(body); }
  [[nodiscard]] Result<void> move_body(int body, const Pose& world_T_body) override;
  void set_person(int person, const Pose2& pose) override;
  [[nodiscard]] std::optional<int> gripped(int finger_joint) const override {
    return grips_->gripped(finger_joint);
  }
  [[nodiscard]] double grip_force(int finger_joint) const override { return grips_->force(finger_joint); }

 private:
  [[nodiscard]] bool is_jump() const;
  void update_links();

  BodiesParams params_;
  RobotModel model_;
  RobotPlan plan_;
  PhysicsWorld world_;
  std::unique_ptr<Scenery> scenery_;
  std::unique_ptr<Chassis> chassis_;
  std::unique_ptr<RobotBody> robot_;
  std::unique_ptr<Grips> grips_;
  Pose world_T_root_;
  Pose next_root_;
  std::vector<Pose> world_T_link_;
  std::vector<double> gravity_efforts_;
};

Result<void> BulletBodies::build(const WorldSpec& spec, const std::vector<double>& start) {
  auto scenery = Scenery::make(world_, spec);
  if (!scenery) return tl::unexpected<Error>(scenery.error());
  scenery_ = std::move(*scenery);
  auto chassis = Chassis::make(world_, plan_, world_T_root_);
  if (!chassis) return tl::unexpected<Error>(chassis.error());
  chassis_ = std::move(*chassis);
  auto robot = params_.dynamic ? DynamicRobot::make(world_, *scenery_, plan_, world_T_root_, start)
                               : KinematicRobot::make(world_, *scenery_, plan_, world_T_root_, start);
  if (!robot) return tl::unexpected<Error>(robot.error());
  robot_ = std::move(*robot);
  grips_ = std::make_unique<Grips>(params_, plan_, world_, *scenery_, *robot_);
  update_links();
  return {};
}

void BulletBodies::set_root(const Pose& world_T_root) {
  if (world_T_root.matrix().allFinite()) next_root_ = world_T_root;
}

bool BulletBodies::is_jump() const {
  const Pose moved = world_T_root_.inverse() * next_root_;
  return moved.translation().norm() > kJumpSpeed * params_.step_s ||
         Eigen::AngleAxisd(moved.linear()).angle() > kJumpRotation * params_.step_s;
}

void BulletBodies::update_links() {
  world_T_link_ = model_.link_poses(robot_->positions());
  for (Pose& pose : world_T_link_) pose = world_T_root_ * pose;
  gravity_efforts_ = simulate::gravity_efforts(model_, plan_.tree, world_T_link_, params_.gravity_m_s2);
}

void BulletBodies::step() {
  if (is_jump()) {
    chassis_->body().place(next_root_);
    robot_->jump(next_root_);
  }
  chassis_->body().aim(next_root_);
  robot_->before_step(next_root_);
  scenery_->before_step();
  world_.step();
  scenery_->after_step();
  robot_->after_step();
  chassis_->body().arrive();
  world_T_root_ = next_root_;
  update_links();
  grips_->update();
}

Result<void> BulletBodies::move_body(int body, const Pose& world_T_body) {
  if (body < 0 || body >= scenery_->size())
    return fail(ErrorCode::kNotFound, "bodies: there is no body " + std::to_string(body));
  if (scenery_->mobility(body) == Mobility::kFixed)
    return fail(ErrorCode::kInvalidArgument, "bodies: body " + std::to_string(body) +
                                                 " is fixed: make it movable or loose in the world file");
  if (!world_T_body.matrix().allFinite())
    return fail(ErrorCode::kInvalidArgument, "bodies: the pose to move to is not finite");
  grips_->let_go_of(body);
  scenery_->place(body, world_T_body);
  return {};
}

void BulletBodies::set_person(int person, const Pose2& pose) {
  if (std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.yaw))
    scenery_->aim_person(person, pose);
}

}  // namespace

Result<std::unique_ptr<Bodies>> Bodies::make(const BodiesParams& params, const RobotModel& robot,
                                             const WorldSpec& world, const Pose& world_T_root,
                                             const std::vector<double>& start_positions) {
  if (auto checked = check(params, robot, world_T_root, start_positions); !checked)
    return tl::unexpected<Error>(checked.error());
  auto bodies = std::make_unique<BulletBodies>(params, robot, world_T_root);
  if (auto built = bodies->build(world, start_positions); !built) return tl::unexpected<Error>(built.error());
  return bodies;
}

}  // namespace extperfc::simulate
