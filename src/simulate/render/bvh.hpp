#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace extperfc::simulate::render {

struct Bounds {
  Eigen::Array3f low{Eigen::Array3f::Constant(3e38F)};
  Eigen::Array3f high{Eigen::Array3f::Constant(-3e38F)};

  void grow(const Eigen::Array3f& point) {
    low = low.min(point);
    high = high.max(point);
  }
  void grow(const Bounds& other) {
    low = low.min(other.low);
    high = high.max(other.high);
  }
  [[nodiscard]] Eigen::Array3f centre() const { return 0.5F * (low + high); }
  /// Half of the surface.
  [[nodiscard]] float half_area() const {
    const Eigen::Array3f e = (high - low).max(0.0F);
    return e.x() * e.y() + e.y() * e.z() + e.z() * e.x();
  }
};

/// A ray with what its traversal of boxes needs.
struct BvhRay {
  Eigen::Array3f origin, direction, inverse;
  float near;
  float far;

  BvhRay(const Eigen::Array3f& from, const Eigen::Array3f& along, float near_, float far_);
};

/// Binary tree over boxes, built by the surface-area heuristic in 16 bins (Wald, "On fast construction of
/// SAH-based bounding volume hierarchies", 2007).
class Bvh {
 public:
  /// O(n log n).
  void build(const std::vector<Bounds>& items);

  /// Calls visit(item, ray) for items whose box the ray meets between near and far, nearest subtree first.
  /// `visit` may shorten ray.far; it returns true to end the walk.
  template <typename Visit>
  void walk(BvhRay& ray, Visit visit) const;

 private:
  struct Node {
    Bounds bounds;
    std::uint32_t first;  ///< leaf: first item in order_; inner: left child, the right one follows
    std::uint32_t count;  ///< 0: inner
  };
  static constexpr int kMaxDepth = 64;

  [[nodiscard]] static bool enters(const Bounds& bounds, const BvhRay& ray, float& at);
  void split(std::uint32_t node, const std::vector<Bounds>& items, int depth);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
};

inline BvhRay::BvhRay(const Eigen::Array3f& from, const Eigen::Array3f& along, float near_, float far_)
    : origin(from), direction(along), near(near_), far(far_) {
  // A direction of zero would give 0 * infinity on a box's side.
  for (int i = 0; i < 3; ++i)
    inverse[i] = 1.0F / (std::abs(along[i]) > 1e-20F ? along[i] : std::copysign(1e-20F, along[i]));
}

inline bool Bvh::enters(const Bounds& bounds, const BvhRay& ray, float& at) {
  const Eigen::Array3f a = (bounds.low - ray.origin) * ray.inverse;
  const Eigen::Array3f b = (bounds.high - ray.origin) * ray.inverse;
  at = std::max(a.min(b).maxCoeff(), ray.near);
  // Rounding must not open gaps between boxes.
  return at <= std::min(a.max(b).minCoeff() * 1.000001F, ray.far);
}

template <typename Visit>
void Bvh::walk(BvhRay& ray, Visit visit) const {
  struct Entry {
    std::uint32_t node;
    float at;
  };
  std::array<Entry, kMaxDepth + 2> stack{};
  std::size_t size = 0;
  float at = 0;
  if (!nodes_.empty() && enters(nodes_[0].bounds, ray, at)) stack[size++] = {0, at};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.at > ray.far) continue;
    const Node& node = nodes_[entry.node];
    for (std::uint32_t i = 0; i < node.count; ++i)
      if (visit(order_[node.first + i], ray)) return;
    if (node.count > 0) continue;
    Entry left{node.first, 0};
    Entry right{node.first + 1, 0};
    const bool goes_left = enters(nodes_[left.node].bounds, ray, left.at);
    const bool goes_right = enters(nodes_[right.node].bounds, ray, right.at);
    const bool left_first = left.at <= right.at;
    if (left_first ? goes_right : goes_left) stack[size++] = left_first ? right : left;
    if (left_first ? goes_left : goes_right) stack[size++] = left_first ? left : right;
  }
}

}  // namespace extperfc::simulate::render
