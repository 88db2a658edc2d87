#include "test/benchmark/arm/ik_part.hpp"

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>

#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainiksolverpos_nr_jl.hpp>
#include <kdl/chainiksolvervel_pinv.hpp>

#include "extperfc/arm/inverse_kinematics.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/base/running_stats.hpp"
#include "extperfc/base/stopwatch.hpp"

namespace extperfc::benchmark {
namespace {

using arm::ArmChain;
using arm::JointVector;

constexpr double kTolerance = 1e-5;  // [m], [rad] per axis
constexpr double kOurTimeS = 1e-3;
constexpr double kPeerTimeS = 5e-3;
constexpr int kPoses = 100'000;
constexpr int kPeerPoses = 2'000;

struct Solved {
  bool done{false};
  JointVector joints;
  double time_s{0};
};
/// Gives up soon after its time.
using Solve = std::function<Solved(const Pose& target)>;

JointVector random_joints(const ArmChain& chain, Rng& rng) {
  JointVector joints(chain.joint_count());
  for (int i = 0; i < chain.joint_count(); ++i)
    joints[i] = rng.uniform(chain.limits().lower[i], chain.limits().upper[i]);
  return joints;
}

std::vector<Pose> reachable_poses(const ArmChain& chain, int count) {
  Rng rng(2026);
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) poses.push_back(chain.forward(random_joints(chain, rng)));
  return poses;
}

bool holds(const ArmChain& chain, const Pose& target, const JointVector& joints) {
  constexpr double kRounding = 1 + 1e-3;  // the orientation's error is a chord here
  const Pose tip = target.inverse() * chain.forward(joints);
  const Eigen::AngleAxisd rotation(tip.linear());
  return tip.translation().cwiseAbs().maxCoeff() <= kRounding * kTolerance &&
         std::abs(rotation.angle()) <= std::sqrt(3.0) * kRounding * kTolerance;
}

struct Figures {
  double solved_percent{0}, mean_us{0}, median_us{0}, p999_us{0};
  double violated{0};  ///< results beyond a joint limit
};

Figures measure(const ArmChain& chain, const std::vector<Pose>& poses, double time_s, const Solve& solve) {
  Figures figures;
  std::vector<double> times_us;
  int solved = 0;
  for (const Pose& target : poses) {
    const Solved result = solve(target);
    times_us.push_back(1e6 * result.time_s);
    if (!result.done) continue;
    if (!chain.within_limits(result.joints)) ++figures.violated;
    if (result.time_s <= time_s && holds(chain, target, result.joints)) ++solved;
  }
  const auto count = static_cast<double>(poses.size());
  figures.solved_percent = 100 * solved / count;
  figures.mean_us = std::accumulate(times_us.begin(), times_us.end(), 0.0) / count;
  figures.median_us = percentile(times_us, 0.5);
  figures.p999_us = percentile(times_us, 0.999);
  return figures;
}

/// The wall clock's limit is wide, since other programs use the machine; measure() applies kOurTimeS.
Figures measure_ours(const ArmChain& chain, const std::vector<Pose>& poses, arm::IkObjective objective) {
  const arm::InverseKinematics kinematics(chain);
  arm::IkOptions options;
  options.tolerance.position_m.setConstant(kTolerance);
  options.tolerance.orientation_rad.setConstant(kTolerance);
  options.timeout_s = 1;
  options.objective = objective;
  const JointVector seed = chain.mid_range();
  return measure(chain, poses, kOurTimeS, [&](const Pose& target) {
    const CpuStopwatch watch;
    const auto result = kinematics.solve(target, seed, options);
    const double time_s = watch.seconds();
    return result ? Solved{true, result->joints, time_s} : Solved{false, {}, time_s};
  });
}

/// Newton's method with its joint limits; goes on from where it stopped until its time is up.
Figures measure_nr_jl(const ArmChain& chain, const std::vector<Pose>& poses) {
  KDL::ChainFkSolverPos_recursive position(chain.kdl());
  KDL::ChainIkSolverVel_pinv velocity(chain.kdl());
  KDL::ChainIkSolverPos_NR_JL solver(chain.kdl(), arm::to_kdl(chain.limits().lower),
                                     arm::to_kdl(chain.limits().upper), position, velocity, 100, kTolerance);
  return measure(chain, poses, kPeerTimeS, [&](const Pose& target) {
    const KDL::Frame frame = arm::to_kdl(target);
    KDL::JntArray start = arm::to_kdl(chain.mid_range());
    KDL::JntArray out = start;
    const CpuStopwatch watch;
    do {
      if (solver.CartToJnt(start, frame, out) >= 0) return Solved{true, arm::from_kdl(out), watch.seconds()};
      start = out;
    } while (watch.seconds() < kPeerTimeS);
    return Solved{false, {}, watch.seconds()};
  });
}

/// Levenberg-Marquardt, which knows no limits, with random restarts until a result, turned back by whole
/// turns, lies within them.
Figures measure_lma(const ArmChain& chain, const std::vector<Pose>& poses) {
  KDL::ChainIkSolverPos_LMA solver(chain.kdl(), Eigen::Matrix<double, 6, 1>::Ones(), kTolerance, 100);
  Rng rng(1);
  return measure(chain, poses, kPeerTimeS, [&](const Pose& target) {
    const KDL::Frame frame = arm::to_kdl(target);
    KDL::JntArray start = arm::to_kdl(chain.mid_range());
    KDL::JntArray out = start;
    const CpuStopwatch watch;
    do {
      if (solver.CartToJnt(start, frame, out) >= 0) {
        JointVector joints = arm::from_kdl(out);
        for (double& joint : joints) joint = wrap_angle(joint);
        if (chain.within_limits(joints)) return Solved{true, joints, watch.seconds()};
      }
      start = arm::to_kdl(random_joints(chain, rng));
    } while (watch.seconds() < kPeerTimeS);
    return Solved{false, {}, watch.seconds()};
  });
}

struct Peer {
  std::string name;
  Figures figures;
};

/// `peer`: nothing, or one solver's figures.
void add_rows(const std::string& name, const Figures& ours, const std::optional<Peer>& peer,
              std::vector<Row>& rows) {
  const auto row = [&](const std::string& metric, const std::string& unit, double Figures::*value) {
    Row out{name, metric, unit, ours.*value};
    if (!peer) return out;
    out.peer = peer->figures.*value;
    out.peer_name = peer->name;
    return out;
  };
  rows.push_back(at_least(row("solved (1 ms, peer 5 ms)", "%", &Figures::solved_percent), 99.99));
  rows.push_back(at_most(row("CPU time, mean", "us", &Figures::mean_us), 30));
  rows.push_back(row("CPU time, median", "us", &Figures::median_us));
  rows.push_back(row("CPU time, 99.9 %", "us", &Figures::p999_us));
  rows.push_back(at_most(row("results beyond limits", "", &Figures::violated), 0));
}

}  // namespace

Result<std::vector<Row>> ik_rows(bool quick) {
  const std::filesystem::path root = EXTPERFC_SOURCE_DIR;
  const auto robot = RobotModel::from_file(root / "urdf/mobile_baxter.urdf", root);
  if (!robot) return tl::unexpected(robot.error());
  const auto chain = ArmChain::make(*robot, "base", "left_gripper");
  if (!chain) return tl::unexpected(chain.error());
  const auto poses = reachable_poses(*chain, quick ? kPoses / 20 : kPoses);
  const std::vector<Pose> few(poses.begin(), poses.begin() + (quick ? kPeerPoses / 10 : kPeerPoses));
  std::vector<Row> rows;
  const Figures all = measure_ours(*chain, poses, arm::IkObjective::kNone);
  add_rows("IK, " + std::to_string(poses.size()) + " poses", all, std::nullopt, rows);
  const Figures ours = measure_ours(*chain, few, arm::IkObjective::kNone);
  const std::string name = "IK, " + std::to_string(few.size()) + " poses";
  add_rows(name, ours, Peer{"KDL LMA + restarts", measure_lma(*chain, few)}, rows);
  add_rows(name, ours, Peer{"KDL NR_JL", measure_nr_jl(*chain, few)}, rows);
  const Figures near = measure_ours(*chain, few, arm::IkObjective::kNearSeed);
  rows.push_back({name + ", near the seed", "CPU time, mean", "us", near.mean_us});
  return rows;
}

}  // namespace extperfc::benchmark
