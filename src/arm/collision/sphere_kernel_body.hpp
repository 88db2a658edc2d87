#pragma once

// The kernel itself; see kernel_lanes.hpp. Each sphere_kernel_<set>.cpp includes this once.

#include "arm/collision/kernel_shapes.hpp"

namespace extperfc::arm {
namespace {

struct BodyLanes {
  Lanes rotation[9];  ///< root_R_body, row by row
  Lanes3 origin;      ///< [m]
  Lanes3 twist[2];    ///< as Probe::twist; the second one is of the point at the root's origin
  Lanes3 ball;        ///< its centre in the root frame
  Lanes range;        ///< of the ball's centre over all lanes: smallest x, y, z, largest x, y, z
};

/// One batch.
template <bool kMoving>
class Batch {
 public:
  Batch(const KernelScene& scene, const KernelMotion* motion, const KernelScratch& scratch)
      : scene_(scene),
        motion_(motion),
        bodies_(reinterpret_cast<BodyLanes*>(scratch.floats)),
        part_balls_(reinterpret_cast<Lanes3*>(bodies_ + scene.body_count)),
        spheres_(part_balls_ + scene.part_count),
        ball_done_(scratch.bytes),
        spheres_done_(scratch.bytes + scene.part_count),
        flags_(scratch.flags) {
    for (int i = 0; i < 2 * scene.part_count; ++i) scratch.bytes[i] = 0;
  }

  int run(const float* positions) {
    place_bodies(positions);
    for (int i = 0; i < scene_.world_group_count; ++i) test_world(scene_.world_groups[i]);
    for (int i = 0; i < scene_.self_group_count; ++i) test_self(i);
    return flag_count_;
  }

 private:
  void place_bodies(const float* positions) {
    BodyLanes& fixed = bodies_[0];
    for (int k = 0; k < 9; ++k) fixed.rotation[k] = all(k % 4 == 0 ? 1.0F : 0.0F);
    fixed.origin = fixed.twist[0] = fixed.twist[1] = Lanes3{};
    for (int i = 1; i < scene_.body_count; ++i) {
      const KernelBody& body = scene_.bodies[i];
      const Lanes value = load(positions + body.joint * kLanes) * body.multiplier + body.offset;
      place_joint(body, bodies_[i]);
      if (body.prismatic)
        slide(bodies_[i], value);
      else
        rotate(bodies_[i], value);
      if (kMoving) add_rate(body, bodies_[i], motion_->rates[i]);
      bodies_[i].ball = transformed(bodies_[i], body.ball);
      const Lanes3& ball = bodies_[i].ball;
      const Lanes* axes[] = {&ball.x, &ball.y, &ball.z};
      for (int axis = 0; axis < 3; ++axis) {
        float low = 0, high = 0;
        range(*axes[axis], low, high);
        bodies_[i].range[axis] = low;
        bodies_[i].range[3 + axis] = high;
      }
    }
  }

  /// The joint's frame before its motion.
  void place_joint(const KernelBody& body, BodyLanes& own) const {
    const BodyLanes& parent = bodies_[body.parent];
    if (body.parent == 0) {
      for (int k = 0; k < 9; ++k) own.rotation[k] = all(body.rotation[k]);
      own.origin = {all(body.translation[0]), all(body.translation[1]), all(body.translation[2])};
      return;
    }
    for (int row = 0; row < 9; row += 3)
      for (int column = 0; column < 3; ++column)
        own.rotation[row + column] = parent.rotation[row] * body.rotation[column] +
                                     parent.rotation[row + 1] * body.rotation[3 + column] +
                                     parent.rotation[row + 2] * body.rotation[6 + column];
    own.origin = transformed(parent, body.translation);
  }

  static void slide(BodyLanes& own, Lanes value) {
    own.origin.x += own.rotation[2] * value;
    own.origin.y += own.rotation[5] * value;
    own.origin.z += own.rotation[8] * value;
  }

  static void rotate(BodyLanes& own, Lanes value) {
    Lanes sine, cosine;
    sine_cosine(value, sine, cosine);
    for (int row = 0; row < 9; row += 3) {
      const Lanes x = own.rotation[row], y = own.rotation[row + 1];
      own.rotation[row] = x * cosine + y * sine;
      own.rotation[row + 1] = y * cosine - x * sine;
    }
  }

  void add_rate(const KernelBody& body, BodyLanes& own, float rate) const {
    const BodyLanes& parent = bodies_[body.parent];
    const Lanes3 axis{own.rotation[2] * rate, own.rotation[5] * rate, own.rotation[8] * rate};
    const Lanes3 &w = parent.twist[0], &v = parent.twist[1], &p = own.origin;
    if (body.prismatic) {
      own.twist[0] = w;
      own.twist[1] = {v.x + axis.x, v.y + axis.y, v.z + axis.z};
      return;
    }
    own.twist[0] = {w.x + axis.x, w.y + axis.y, w.z + axis.z};
    own.twist[1] = {v.x + p.y * axis.z - p.z * axis.y, v.y + p.z * axis.x - p.x * axis.z,
                    v.z + p.x * axis.y - p.y * axis.x};
  }

  static Lanes3 transformed(const BodyLanes& body, const float* point) {
    const Lanes* r = body.rotation;
    return {body.origin.x + r[0] * point[0] + r[1] * point[1] + r[2] * point[2],
            body.origin.y + r[3] * point[0] + r[4] * point[1] + r[5] * point[2],
            body.origin.z + r[6] * point[0] + r[7] * point[1] + r[8] * point[2]};
  }

  const Lanes3& part_ball(int part) {
    const KernelPart& own = scene_.parts[part];
    if (ball_done_[part] == 0) {
      part_balls_[part] = transformed(bodies_[own.body], own.ball.centre);
      ball_done_[part] = 1;
    }
    return part_balls_[part];
  }

  /// Centres of the part's spheres.
  const Lanes3* spheres(int part) {
    const KernelPart& own = scene_.parts[part];
    if (spheres_done_[part] == 0) {
      for (int i = own.first_sphere; i < own.sphere_end; ++i)
        spheres_[i] = transformed(bodies_[own.body], scene_.spheres[i].centre);
      spheres_done_[part] = 1;
    }
    return spheres_ + own.first_sphere;
  }

  [[nodiscard]] Probe probe(int body, const Lanes3& centre, float limit, KernelDrift drift) const {
    return {centre, limit, drift, kMoving ? motion_->half : 0.0F, bodies_[body].twist};
  }

  void flag(int pair, Mask lanes) {
    if (const unsigned set = bits(lanes)) flags_[flag_count_++] = {pair, set};
  }

  /// Whether the obstacle's box is further than `distance` from the body's ball in every lane.
  [[nodiscard]] static bool box_apart(const BodyLanes& body, const KernelObstacle& obstacle, float distance) {
    for (int axis = 0; axis < 3; ++axis)
      if (body.range[axis] - obstacle.high[axis] > distance ||
          obstacle.low[axis] - body.range[3 + axis] > distance)
        return true;
    return false;
  }

  void test_world(const KernelGroup& group) {
    const KernelObstacle& obstacle = scene_.obstacles[group.other];
    const KernelDrift drift = kMoving ? motion_->world_drift[group.body] : KernelDrift{};
    const float limit = scene_.bodies[group.body].ball_radius + group.padding;
    if (box_apart(bodies_[group.body], obstacle, limit + drift.shift)) return;
    const Probe whole = probe(group.body, bodies_[group.body].ball, limit, drift);
    if (bits(near_obstacle<kMoving>(scene_, obstacle, whole)) == 0) return;
    for (int i = group.first_pair; i < group.pair_end; ++i)
      flag(i, part_near_obstacle(scene_.pairs[i], obstacle, drift));
  }

  Mask part_near_obstacle(const KernelPair& pair, const KernelObstacle& obstacle, KernelDrift drift) {
    const KernelPart& part = scene_.parts[pair.part];
    const Probe ball = probe(part.body, part_ball(pair.part), part.ball.radius + pair.padding, drift);
    const Mask doubtful = near_obstacle<kMoving>(scene_, obstacle, ball);
    if (bits(doubtful) == 0) return doubtful;
    const Lanes3* centres = spheres(pair.part);
    Mask hit{};
    for (int i = part.first_sphere; i < part.sphere_end && bits(doubtful & ~hit) != 0; ++i) {
      const float limit = scene_.spheres[i].radius + pair.padding;
      hit |= near_obstacle<kMoving>(scene_, obstacle,
                                    probe(part.body, centres[i - part.first_sphere], limit, drift));
    }
    return hit & doubtful;
  }

  void test_self(int index) {
    const KernelGroup& group = scene_.self_groups[index];
    const KernelDrift drift = kMoving ? motion_->self_drift[index] : KernelDrift{};
    const Probe a = probe(group.body, bodies_[group.body].ball, 0, drift);
    const Probe b = probe(group.other, bodies_[group.other].ball, 0, drift);
    const float limit =
        scene_.bodies[group.body].ball_radius + scene_.bodies[group.other].ball_radius + group.padding;
    if (bits(near_probe<kMoving>(a, b, limit)) == 0) return;
    for (int i = group.first_pair; i < group.pair_end; ++i) flag(i, parts_near(scene_.pairs[i], drift));
  }

  Mask parts_near(const KernelPair& pair, KernelDrift drift) {
    const KernelPart &first = scene_.parts[pair.part], &second = scene_.parts[pair.other];
    const Probe a = probe(first.body, part_ball(pair.part), 0, drift);
    const Probe b = probe(second.body, part_ball(pair.other), 0, drift);
    const Mask doubtful = near_probe<kMoving>(a, b, first.ball.radius + second.ball.radius + pair.padding);
    if (bits(doubtful) == 0) return doubtful;
    const Lanes3* centres = spheres(pair.part);
    Mask hit{};
    for (int i = first.first_sphere; i < first.sphere_end && bits(doubtful & ~hit) != 0; ++i)
      hit |= sphere_near_part(probe(first.body, centres[i - first.first_sphere], 0, drift),
                              scene_.spheres[i].radius + pair.padding, b, pair.other);
    return hit & doubtful;
  }

  Mask sphere_near_part(const Probe& sphere, float limit, const Probe& ball, int part) {
    const KernelPart& own = scene_.parts[part];
    const Mask doubtful = near_probe<kMoving>(sphere, ball, limit + own.ball.radius);
    if (bits(doubtful) == 0) return doubtful;
    const Lanes3* centres = spheres(part);
    Mask hit{};
    for (int i = own.first_sphere; i < own.sphere_end; ++i)
      hit |= near_probe<kMoving>(sphere, probe(own.body, centres[i - own.first_sphere], 0, ball.drift),
                                 limit + scene_.spheres[i].radius);
    return hit & doubtful;
  }

  const KernelScene& scene_;
  const KernelMotion* motion_;
  BodyLanes* bodies_;
  Lanes3* part_balls_;
  Lanes3* spheres_;
  unsigned char* ball_done_;
  unsigned char* spheres_done_;
  KernelFlag* flags_;
  int flag_count_{0};
};

inline int run_batch(const KernelScene& scene, const float* positions, const KernelMotion* motion,
                     const KernelScratch& scratch) {
  if (motion == nullptr) return Batch<false>(scene, motion, scratch).run(positions);
  return Batch<true>(scene, motion, scratch).run(positions);
}

}  // namespace
}  // namespace extperfc::arm
