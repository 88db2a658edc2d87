#include "simulate/render/bvh.hpp"

#include <algorithm>
#include <numeric>

namespace extperfc::simulate::render {

namespace {

constexpr int kBins = 16;
constexpr std::uint32_t kLeafItems = 2;

struct Bin {
  Bounds bounds;
  std::uint32_t count{0};
};
using Bins = std::array<Bin, kBins>;

struct Cut {
  int axis{-1};
  int bin{0};  ///< last bin of the left side
  float cost{3e38F};
};

int bin_of(const Bounds& item, const Bounds& centres, int axis) {
  const float width = centres.high[axis] - centres.low[axis];
  const float at = (item.centre()[axis] - centres.low[axis]) / width;
  return std::clamp(static_cast<int>(at * kBins), 0, kBins - 1);
}

/// Cheapest place to cut along one axis.
void consider(const Bins& bins, int axis, Cut& best) {
  std::array<float, kBins> right_cost{};
  Bin right;
  for (int i = kBins - 1; i > 0; --i) {
    const auto& bin = bins[static_cast<std::size_t>(i)];
    right.bounds.grow(bin.bounds);
    right.count += bin.count;
    right_cost[static_cast<std::size_t>(i)] =
        right.count == 0 ? 3e38F : right.bounds.half_area() * static_cast<float>(right.count);
  }
  Bin left;
  for (int i = 0; i + 1 < kBins; ++i) {
    const auto& bin = bins[static_cast<std::size_t>(i)];
    left.bounds.grow(bin.bounds);
    left.count += bin.count;
    if (left.count == 0) continue;
    const float cost = left.bounds.half_area() * static_cast<float>(left.count) +
                       right_cost[static_cast<std::size_t>(i) + 1];
    if (cost < best.cost) best = {axis, i, cost};
  }
}

}  // namespace

void Bvh::build(const std::vector<Bounds>& items) {
  nodes_.clear();
  order_.resize(items.size());
  std::iota(order_.begin(), order_.end(), 0U);
  if (items.empty()) return;
  nodes_.reserve(2 * items.size());
  nodes_.push_back({{}, 0, static_cast<std::uint32_t>(items.size())});
  split(0, items, 0);
}

void Bvh::split(std::uint32_t index, const std::vector<Bounds>& items, int depth) {
  const std::uint32_t first = nodes_[index].first;
  const std::uint32_t count = nodes_[index].count;
  const auto begin = order_.begin() + first;
  const auto end = begin + count;
  Bounds bounds;
  Bounds centres;
  for (auto i = begin; i != end; ++i) {
    bounds.grow(items[*i]);
    centres.grow(items[*i].centre());
  }
  nodes_[index].bounds = bounds;
  if (count <= kLeafItems || depth >= kMaxDepth) return;

  Cut best;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(centres.high[axis] > centres.low[axis])) continue;
    Bins bins;
    for (auto i = begin; i != end; ++i) {
      auto& bin = bins[static_cast<std::size_t>(bin_of(items[*i], centres, axis))];
      bin.bounds.grow(items[*i]);
      ++bin.count;
    }
    consider(bins, axis, best);
  }
  if (best.axis < 0) return;
  const auto middle = std::partition(
      begin, end, [&](std::uint32_t item) { return bin_of(items[item], centres, best.axis) <= best.bin; });
  const auto left_count = static_cast<std::uint32_t>(middle - begin);
  if (left_count == 0 || left_count == count) return;
  const auto left = static_cast<std::uint32_t>(nodes_.size());
  nodes_[index] = {bounds, left, 0};
  nodes_.push_back({{}, first, left_count});
  nodes_.push_back({{}, first + left_count, count - left_count});
  split(left, items, depth + 1);
  split(left + 1, items, depth + 1);
}

}  // namespace extperfc::simulate::render
