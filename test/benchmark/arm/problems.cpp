#include "test/benchmark/arm/problems.hpp"

#include <array>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include "extperfc/arm/srdf.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::benchmark {

namespace {

constexpr int kArmJoints = 7;
constexpr std::array<const char*, kArmJoints> kJoints{"s0", "s1", "e0", "e1", "w0", "w1", "w2"};
const std::filesystem::path kRoot = EXTPERFC_SOURCE_DIR;

/// The numbers of a line behind its first word, when there are `count` of them.
std::optional<std::vector<double>> numbers(std::istringstream& line, std::size_t count) {
  std::vector<double> values;
  for (double value = 0; line >> value;) values.push_back(value);
  if (values.size() != count || !line.eof()) return std::nullopt;
  return values;
}

arm::WorldObject object_of(std::size_t number, const Geometry& geometry, const std::vector<double>& pose) {
  arm::WorldObject object;
  object.name = "object_" + std::to_string(number);
  object.shapes.push_back({geometry, Pose::Identity(), {}});
  object.root_T_object.translation() = Eigen::Vector3d(pose[0], pose[1], pose[2]);
  object.root_T_object.linear() =
      Eigen::Quaterniond(pose[6], pose[3], pose[4], pose[5]).normalized().toRotationMatrix();
  return object;
}

/// Takes in one line; false when it does not fit its kind.
bool read_line(const std::string& kind, std::istringstream& line, ArmProblem* problem) {
  constexpr std::size_t kPose = 7;
  const auto add = [&](const std::optional<std::vector<double>>& values, auto make) {
    if (values)
      problem->objects.push_back(object_of(problem->objects.size(), make(values->data() + kPose), *values));
    return values.has_value();
  };
  if (kind == "BOX")
    return add(numbers(line, kPose + 3), [](const double* v) { return Box{{2 * v[0], 2 * v[1], 2 * v[2]}}; });
  if (kind == "CYL")
    return add(numbers(line, kPose + 2), [](const double* v) { return Cylinder{v[0], v[1]}; });
  if (kind == "SPH") return add(numbers(line, kPose + 1), [](const double* v) { return Sphere{v[0]}; });
  return false;
}

/// "START 14 values GOAL 14 values", in one line or in two.
bool read_states(const std::string& kind, std::istringstream& line, ArmProblem* problem) {
  int count = 0;
  if (!(line >> count) || count != 2 * kArmJoints) return false;
  arm::JointVector state(count);
  for (int j = 0; j < count; ++j)
    if (!(line >> state[j])) return false;
  (kind == "START" ? problem->start : problem->goal) = state;
  std::string next;
  if (!(line >> next)) return true;
  return kind == "START" && next == "GOAL" && read_states(next, line, problem);
}

}  // namespace

Result<std::vector<ArmProblem>> read_problems(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) return fail(ErrorCode::kNotFound, "no such file: " + file.string());
  std::vector<ArmProblem> problems;
  bool open = false;
  std::string text;
  for (int number = 1; std::getline(stream, text); ++number) {
    std::istringstream line(text);
    std::string kind;
    if (!(line >> kind)) continue;
    bool fits = true;
    if (kind == "PROBLEM") {
      std::string set;
      problems.emplace_back();
      fits = !open && static_cast<bool>(line >> set >> problems.back().index);
      open = true;
    } else if (kind == "END") {
      fits =
          std::exchange(open, false) && problems.back().start.size() > 0 && problems.back().goal.size() > 0;
    } else {
      fits = open && (kind == "START" || kind == "GOAL" ? read_states(kind, line, &problems.back())
                                                        : read_line(kind, line, &problems.back()));
    }
    if (!fits)
      return fail(ErrorCode::kCorrupt,
                  file.string() + ":" + std::to_string(number) + ": not a line of a problem file");
  }
  if (open) return fail(ErrorCode::kCorrupt, file.string() + " ends within a problem");
  return problems;
}

arm::JointVector states_of(const arm::JointVector& both, ArmGroup group) {
  return group == ArmGroup::kBoth ? both : arm::JointVector(both.head(kArmJoints));
}

const Result<arm::RobotArms>& baxter_arms() {
  static const Result<arm::RobotArms> arms = []() -> Result<arm::RobotArms> {
    auto robot = RobotModel::from_file(kRoot / "urdf/mobile_baxter.urdf", kRoot);
    if (!robot) return tl::unexpected(robot.error());
    auto srdf = arm::read_srdf(kRoot / "config/robots/baxter/mobile_baxter.srdf");
    if (!srdf) return tl::unexpected(srdf.error());
    return arm::RobotArms::make(*robot, *srdf);
  }();
  return arms;
}

namespace {

/// Both arms at the problem's start, grippers open.
arm::JointPositions standing(const ArmProblem& problem) {
  constexpr double kOpenM = 0.020833;
  arm::JointPositions positions;
  for (const char* side : {"l", "r"}) {
    positions[std::string(side) + "_gripper_l_finger_joint"] = kOpenM;
    positions[std::string(side) + "_gripper_r_finger_joint"] = -kOpenM;
  }
  for (int j = 0; j < kArmJoints; ++j) {
    positions[std::string("left_") + kJoints[j]] = problem.start[j];
    positions[std::string("right_") + kJoints[j]] = problem.start[kArmJoints + j];
  }
  return positions;
}

Result<arm::CollisionModel> make_model(const arm::RobotArms& arms, const arm::JointPositions& positions,
                                       ArmGroup group) {
  arm::CollisionModelParams params;
  params.allowed = arm::allowed_pairs(arms.srdf());
  params.fixed_positions = positions;
  for (const char* side : {"left_", "right_"})
    for (const char* joint : kJoints) {
      if (group == ArmGroup::kLeft && side[0] == 'r') continue;
      params.joints.push_back(std::string(side) + joint);
      params.fixed_positions.erase(params.joints.back());
    }
  return arm::CollisionModel::make(arms.robot(), params);
}

bool is_finger(const std::string& link) {
  return link.find("_gripper_") != std::string::npos && link.find("finger") != std::string::npos;
}

/// The goals are grasps: what only fingers touch there, fingers may touch. The fingers of the robot that the
/// set was made for are not known; ours open to 4 cm, and the objects to grasp are 6 cm wide.
Result<void> allow_grasps(const arm::CollisionModel& model, const arm::JointVector& goal,
                          arm::CollisionWorld* world) {
  const std::size_t count = world->objects().size();
  for (std::size_t i = 0; i < count; ++i) {
    auto exact = arm::CollisionChecker::make(model, *world, {1e-3, false});
    if (!exact) return tl::unexpected(exact.error());
    const auto contact = exact->contact(goal);
    if (!contact) return {};
    const auto& link = is_finger(contact->first) ? contact->first : contact->second;
    const auto& object = is_finger(contact->first) ? contact->second : contact->first;
    if (!is_finger(link) || world->objects().count(object) == 0) return {};
    for (const char* finger :
         {"_gripper_l_finger", "_gripper_l_finger_tip", "_gripper_r_finger", "_gripper_r_finger_tip"})
      world->allow(object, link.substr(0, 1) + finger);
  }
  return {};
}

}  // namespace

Result<ProblemScene> make_scene(const ArmProblem& problem, ArmGroup group) {
  const auto& arms = baxter_arms();
  if (!arms) return tl::unexpected(arms.error());
  const auto positions = standing(problem);
  auto model = make_model(*arms, positions, group);
  if (!model) return tl::unexpected(model.error());
  const Pose root_T_base = *model->link_pose(arm::JointVector::Zero(model->joint_count()), "base");
  arm::CollisionWorld world;
  for (auto object : problem.objects) {
    object.root_T_object = root_T_base * object.root_T_object;
    if (auto added = world.add(object); !added) return tl::unexpected(added.error());
  }
  if (auto allowed = allow_grasps(*model, states_of(problem.goal, group), &world); !allowed)
    return tl::unexpected(allowed.error());
  return ProblemScene{std::move(*model), std::move(world), positions};
}

}  // namespace extperfc::benchmark
