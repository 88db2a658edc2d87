#include "scan/columns.hpp"

#include <algorithm>
#include <cstring>

namespace extperfc::scan {

void Columns::clear(std::size_t rays) {
  waiting_.clear();
  starts_.assign(rays, 0);
  ends_.assign(rays, 0);
}

void Columns::add(std::size_t ray, float range, std::size_t index) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &range, sizeof bits);
  waiting_.push_back({static_cast<std::uint32_t>(ray), std::uint64_t{bits} << 32U | index});
  ++ends_[ray];  // a count until sort()
}

void Columns::sort() {
  std::size_t start = 0;
  for (std::size_t ray = 0; ray < starts_.size(); ++ray) {
    starts_[ray] = start;
    start += ends_[ray];
    ends_[ray] = starts_[ray];
  }
  keys_.resize(waiting_.size());
  for (const Waiting& waiting : waiting_) keys_[ends_[waiting.ray]++] = waiting.key;
  for (std::size_t ray = 0; ray < starts_.size(); ++ray)
    std::sort(keys_.data() + starts_[ray], keys_.data() + ends_[ray]);
  points_.resize(keys_.size());
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const auto bits = static_cast<std::uint32_t>(keys_[i] >> 32U);
    std::memcpy(&points_[i].range, &bits, sizeof bits);
    points_[i].index = static_cast<std::uint32_t>(keys_[i]);
  }
}

Column Columns::column(std::size_t ray) {
  return {points_.data() + starts_[ray], points_.data() + ends_[ray]};
}

}  // namespace extperfc::scan
