#include "arm/collision/scene.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace extperfc::arm {
namespace {

/// Carried objects are covered more coarsely than links: they change often and are handled near others.
constexpr double kCarriedExcess = 0.015;  // [m]

MovingPart moving_part(const Bodies& bodies, const std::string& name, int body,
                       const std::shared_ptr<const ConvexPart>& part, const Pose& body_T_part,
                       const std::vector<Ball>& cover) {
  MovingPart moving{name, body, part, body_T_part, cover, {body_T_part.translation(), bounding_radius(*part)},
                    {}};
  for (Ball& ball : moving.cover) {
    moving.ball.radius = std::max(moving.ball.radius, ball.centre.norm());
    ball.centre = body_T_part * ball.centre;
  }
  moving.reach = reach_of(bodies, body, moving.ball);
  return moving;
}

class SceneBuilder {
 public:
  SceneBuilder(const Bodies& bodies, const CollisionWorld& world) : bodies_(bodies), world_(world) {}

  Result<Scene> build() {
    add_links();
    if (auto done = add_objects(); !done) return tl::unexpected<Error>(done.error());
    if (auto done = add_attached(); !done) return tl::unexpected<Error>(done.error());
    std::stable_sort(scene_.moving.begin(), scene_.moving.end(),
                     [](const MovingPart& a, const MovingPart& b) { return a.body < b.body; });
    for (std::size_t body = 1; body < bodies_.bodies.size(); ++body)
      pair_with_obstacles(static_cast<int>(body));
    for (std::size_t a = 1; a < bodies_.bodies.size(); ++a)
      for (std::size_t b = a + 1; b < bodies_.bodies.size(); ++b)
        pair_bodies(static_cast<int>(a), static_cast<int>(b));
    return std::move(scene_);
  }

 private:
  void add_links() {
    for (const LinkPart& part : bodies_.parts) {
      const std::string& name = bodies_.links[part.link];
      if (part.body == 0)
        scene_.obstacles.push_back({name, part.part, part.body_T_part});
      else
        scene_.moving.push_back(
            moving_part(bodies_, name, part.body, part.part, part.body_T_part, part.cover));
    }
    own_obstacles_ = scene_.obstacles.size();
  }

  [[nodiscard]] Result<void> check_name(const std::string& name) const {
    if (!bodies_.link(name)) return {};
    return fail(ErrorCode::kInvalidArgument, "object " + name + " has the name of a link: give it another");
  }

  Result<void> add_attached() {
    for (const auto& [name, carried] : world_.attached()) {
      if (auto ok = check_name(name); !ok) return ok;
      const auto link = bodies_.link(carried->object.link);
      if (!link)
        return fail(ErrorCode::kNotFound, "object " + name + " is attached to link " + carried->object.link +
                                              ", which the robot lacks");
      allowed_.allow(name, carried->object.link);
      for (const auto& touched : carried->object.touch_links) allowed_.allow(name, touched);
      const int body = bodies_.body_of_link[*link];
      const Pose body_T_object = bodies_.body_T_link[*link] * carried->object.link_T_object;
      for (const auto& part : carried->parts)
        add_carried(name, *link, body, part, body_T_object * part->body_T_part);
    }
    return {};
  }

  void add_carried(const std::string& name, int link, int body, const std::shared_ptr<const ConvexPart>& part,
                   const Pose& body_T_part) {
    carrier_[name] = bodies_.links[link];
    if (body == 0) {
      own_.insert(scene_.obstacles.size());
      scene_.obstacles.push_back({name, part, body_T_part});
    } else {
      const double excess = std::max(kCarriedExcess, bodies_.params.sphere_excess_m);
      scene_.moving.push_back(
          moving_part(bodies_, name, body, part, body_T_part, sphere_cover(*part, excess)));
    }
  }

  Result<void> add_objects() {
    for (const auto& [name, placed] : world_.objects()) {
      if (auto ok = check_name(name); !ok) return ok;
      for (const auto& part : placed->parts)
        scene_.obstacles.push_back({name, part, placed->object.root_T_object * part->body_T_part});
    }
    return {};
  }

  [[nodiscard]] bool allows(const std::string& a, const std::string& b) const {
    return a == b || bodies_.params.allowed.allows(a, b) || world_.allowed().allows(a, b) ||
           allowed_.allows(a, b);
  }

  [[nodiscard]] double padding(const MovingPart& part, int obstacle) const {
    if (is_own(obstacle)) return bodies_.params.self_padding_m;
    const auto carrier = carrier_.find(part.name);
    return bodies_.world_padding_m(carrier == carrier_.end() ? part.name : carrier->second);
  }

  /// Whether it belongs to the robot.
  [[nodiscard]] bool is_own(int obstacle) const {
    return static_cast<std::size_t>(obstacle) < own_obstacles_ || own_.count(obstacle) != 0;
  }

  [[nodiscard]] bool out_of_reach(const MovingPart& part, const Obstacle& obstacle, double padding_m) const {
    const Ball& ball = part.reach.in_root;
    return distance_bound(*obstacle.part, obstacle.root_T_part.inverse() * ball.centre) >
           ball.radius + padding_m;
  }

  void open_group(int body, int other, bool self) {
    const int next = static_cast<int>(scene_.pairs.size());
    scene_.groups.push_back({body, other, self, next, next});
  }

  void close_group() {
    scene_.groups.back().pair_end = static_cast<int>(scene_.pairs.size());
    if (scene_.groups.back().pair_end == scene_.groups.back().first_pair) scene_.groups.pop_back();
  }

  void pair_with_obstacles(int body) {
    for (std::size_t k = 0; k < scene_.obstacles.size(); ++k) {
      const int obstacle = static_cast<int>(k);
      open_group(body, obstacle, false);
      for (std::size_t i = 0; i < scene_.moving.size(); ++i) {
        const MovingPart& part = scene_.moving[i];
        if (part.body != body || allows(part.name, scene_.obstacles[k].name)) continue;
        const double padding_m = padding(part, obstacle);
        if (!out_of_reach(part, scene_.obstacles[k], padding_m))
          scene_.pairs.push_back({static_cast<int>(i), obstacle, false, 0, padding_m});
      }
      close_group();
    }
  }

  void pair_bodies(int a, int b) {
    const int ancestor = common_ancestor(bodies_, a, b);
    open_group(a, b, true);
    for (std::size_t i = 0; i < scene_.moving.size(); ++i)
      for (std::size_t j = 0; j < scene_.moving.size(); ++j)
        if (scene_.moving[i].body == a && scene_.moving[j].body == b &&
            !allows(scene_.moving[i].name, scene_.moving[j].name))
          scene_.pairs.push_back(
              {static_cast<int>(i), static_cast<int>(j), true, ancestor, bodies_.params.self_padding_m});
    close_group();
  }

  const Bodies& bodies_;
  const CollisionWorld& world_;
  Scene scene_;
  AllowedPairs allowed_;
  std::map<std::string, std::string> carrier_;  ///< link of each attached object
  std::size_t own_obstacles_{0};                ///< obstacles that are links
  std::set<std::size_t> own_;                   ///< further obstacles that belong to the robot
};

}  // namespace

Ball body_ball(const Scene& scene, int body) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY), high = -low;
  for (const MovingPart& part : scene.moving)
    if (part.body == body) {
      low = low.cwiseMin((part.ball.centre.array() - part.ball.radius).matrix());
      high = high.cwiseMax((part.ball.centre.array() + part.ball.radius).matrix());
    }
  if (!low.allFinite()) return {};
  Ball ball{(low + high) / 2, 0};
  for (const MovingPart& part : scene.moving)
    if (part.body == body)
      ball.radius = std::max(ball.radius, (part.ball.centre - ball.centre).norm() + part.ball.radius);
  return ball;
}

Result<Scene> make_scene(const Bodies& bodies, const CollisionWorld& world) {
  return SceneBuilder(bodies, world).build();
}

}  // namespace extperfc::arm
