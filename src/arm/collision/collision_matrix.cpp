#include "extperfc/arm/collision_matrix.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"

#include "arm/collision/exact_pairs.hpp"

namespace extperfc::arm {
namespace {
constexpr int kSettledAfter = 1000;  // samples before a pair that is often apart is left alone

/// Every link is a "body" of its own here: poses come from the robot's description.
Result<Scene> scene_of_links(const RobotModel& robot) {
  Scene scene;
  for (std::size_t link = 0; link < robot.links().size(); ++link) {
    const Link& own = robot.links()[link];
    const auto parts = make_convex_parts("link " + own.name, own.collisions);
    if (!parts) return tl::unexpected<Error>(parts.error());
    for (const auto& part : *parts)
      scene.moving.push_back({own.name, static_cast<int>(link), part, part->body_T_part, {}, {}, {}});
  }
  return scene;
}

/// Index of the rigid body of every link.
std::vector<int> rigid_bodies(const RobotModel& robot) {
  std::vector<int> body(robot.links().size(), 0);
  int count = 1;
  for (const Joint& joint : robot.joints())
    body[joint.child_link] = joint.type == JointType::kFixed ? body[joint.parent_link] : count++;
  return body;
}

/// Pairs of links with shapes of which one is the next above the other.
std::set<std::pair<int, int>> adjacent_links(const RobotModel& robot) {
  std::vector<int> above(robot.links().size(), -1);
  std::set<std::pair<int, int>> adjacent;
  for (const Joint& joint : robot.joints()) {
    const int parent = joint.parent_link, child = joint.child_link;
    above[child] = robot.links()[parent].collisions.empty() ? above[parent] : parent;
    if (above[child] >= 0) adjacent.insert(std::minmax(above[child], child));
  }
  return adjacent;
}

/// Moving joints between two links when one hangs from the other, nothing otherwise.
std::optional<int> joints_between(const RobotModel& robot, int above, int below) {
  if (above > below) std::swap(above, below);
  int moving = 0;
  for (int link = below; link != above;) {
    const int carrier = robot.links()[link].parent_joint;
    if (carrier < 0) return std::nullopt;
    const Joint& joint = robot.joints()[carrier];
    moving += joint.type == JointType::kFixed ? 0 : 1;
    link = joint.parent_link;
  }
  return moving;
}

/// The same, counted from the rigid bodies' nearest links: the link that carries the body of `link`.
int carrier_of_body(const RobotModel& robot, int link) {
  while (robot.links()[link].parent_joint >= 0) {
    const Joint& joint = robot.joints()[robot.links()[link].parent_joint];
    if (joint.type != JointType::kFixed) break;
    link = joint.parent_link;
  }
  return link;
}

struct Tally {
  int first_link{0}, second_link{0};
  std::optional<int> between;  ///< moving joints between them on one chain
  bool neighbours{false};
  std::vector<int> pairs;  ///< of the scene
  int tried{0}, touched{0};
  bool near{false};

  [[nodiscard]] bool settled(double limit) const {
    return near && tried >= kSettledAfter && touched < limit * tried / 2 && (touched > 0 || between != 1);
  }
  /// A single joint is sampled densely: there nearness is no evidence.
  [[nodiscard]] bool never() const { return between == 1 ? touched == 0 : !near; }
};

class Sampler {
 public:
  Sampler(const RobotModel& robot, const CollisionMatrixParams& params, Scene& scene)
      : robot_(robot), params_(params), scene_(scene), body_(rigid_bodies(robot)) {
    const auto adjacent = adjacent_links(robot);
    for (std::size_t a = 0; a < scene.moving.size(); ++a)
      for (std::size_t b = a + 1; b < scene.moving.size(); ++b)
        add_pair(static_cast<int>(a), static_cast<int>(b), adjacent);
  }

  std::vector<DisabledPair> run() {
    ExactPairs exact(scene_);
    Rng rng(params_.seed);
    BodyPlacement placement;
    for (int i = 0; i < params_.samples; ++i) {
      placement.set(scene_, robot_.link_poses(random_positions(rng)));
      for (Tally& tally : tallies_)
        if (!tally.settled(ratio_of(tally))) count(tally, exact, placement);
    }
    for (const Tally& tally : tallies_) {
      if (tally.touched >= params_.always * tally.tried)
        disable(tally.first_link, tally.second_link, "Always");
      else if (tally.neighbours && tally.touched > ratio_of(tally) * tally.tried)
        disable(tally.first_link, tally.second_link, "Neighbours");
      if (tally.never()) disable(tally.first_link, tally.second_link, "Never");
    }
    return sorted();
  }

 private:
  void add_pair(int a, int b, const std::set<std::pair<int, int>>& adjacent) {
    const int first = scene_.moving[a].body, second = scene_.moving[b].body;
    if (first == second) return;
    if (body_[first] == body_[second]) return disable(first, second, "Rigid");
    if (adjacent.count(std::minmax(first, second)) != 0) return disable(first, second, "Adjacent");
    const auto same = [&](const Tally& tally) {
      return tally.first_link == first && tally.second_link == second;
    };
    auto tally = std::find_if(tallies_.begin(), tallies_.end(), same);
    if (tally == tallies_.end()) tally = tallies_.insert(tallies_.end(), new_tally(first, second));
    tally->pairs.push_back(static_cast<int>(scene_.pairs.size()));
    scene_.pairs.push_back({a, b, true, first, 0});
  }

  [[nodiscard]] double ratio_of(const Tally& tally) const {
    return tally.neighbours ? params_.neighbour_ratio : params_.always;
  }

  [[nodiscard]] Tally new_tally(int first, int second) const {
    const auto between =
        joints_between(robot_, carrier_of_body(robot_, first), carrier_of_body(robot_, second));
    const bool on_root = body_[first] == 0 || body_[second] == 0;
    return {first, second, between, !on_root && between && *between <= params_.neighbour_joints,
            {},    0,      0,       false};
  }

  void count(Tally& tally, ExactPairs& exact, const BodyPlacement& placement) const {
    ++tally.tried;
    bool touched = false;
    for (const int pair : tally.pairs) {
      if (touched || exact.rough_bound(pair, placement) > params_.clearance_m) continue;
      if (const auto known = exact.remembered(pair, placement); known && known->gap_m > params_.clearance_m)
        continue;
      const double gap = exact.separation(pair, placement).gap_m;
      tally.near = tally.near || gap <= params_.clearance_m;
      touched = gap <= 0;
    }
    tally.touched += touched ? 1 : 0;
  }

  std::vector<double> random_positions(Rng& rng) const {
    std::vector<double> positions;
    for (const Joint& joint : robot_.joints()) {
      const bool continuous = joint.type == JointType::kContinuous;
      positions.push_back(rng.uniform(continuous ? -kPi : joint.lower, continuous ? kPi : joint.upper));
    }
    return positions;
  }

  void disable(int first, int second, const char* reason) {
    const auto names = std::minmax(robot_.links()[first].name, robot_.links()[second].name);
    disabled_[names] = reason;
  }

  std::vector<DisabledPair> sorted() const {
    std::vector<DisabledPair> result;
    for (const auto& [names, reason] : disabled_) result.push_back({names.first, names.second, reason});
    return result;
  }

  const RobotModel& robot_;
  const CollisionMatrixParams& params_;
  Scene& scene_;
  std::vector<int> body_;
  std::vector<Tally> tallies_;
  std::map<std::pair<std::string, std::string>, std::string> disabled_;
};

}  // namespace

Result<std::vector<DisabledPair>> find_disabled_pairs(const RobotModel& robot,
                                                      const CollisionMatrixParams& params) {
  constexpr int kMaxSamples = 10'000'000;
  if (params.samples < 1 || params.samples > kMaxSamples)
    return fail(ErrorCode::kInvalidArgument, "samples must be from 1 to 10 million");
  if (!(params.clearance_m >= 0 && params.clearance_m <= 1))
    return fail(ErrorCode::kInvalidArgument, "clearance_m must be from 0 to 1 m");
  if (params.neighbour_joints < 0 || params.neighbour_joints > 10 || !(params.neighbour_ratio >= 0) ||
      params.neighbour_ratio > 1)
    return fail(ErrorCode::kInvalidArgument,
                "neighbour_joints must be from 0 to 10, neighbour_ratio from 0 to 1");
  if (!(params.always > 0 && params.always <= 1))
    return fail(ErrorCode::kInvalidArgument, "always must be above 0 and not above 1");
  auto scene = scene_of_links(robot);
  if (!scene) return tl::unexpected<Error>(scene.error());
  return Sampler(robot, params, *scene).run();
}

}  // namespace extperfc::arm
