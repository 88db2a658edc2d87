#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace extperfc::navigate {

/// Priority queue of cells whose keys are sorted to one bucket width: push and pop take constant time.
/// Entries of one bucket come last in, first out. Keeps its memory between searches.
class BucketQueue {
 public:
  struct Entry {
    float key;
    std::int32_t value;
  };

  /// Precondition: width > 0; keys below first_key count as first_key.
  void clear(float first_key, float width);
  void push(float key, std::int32_t value);
  /// Precondition: not empty.
  Entry pop();
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::size_t bytes() const {
    return heads_.capacity() * sizeof(std::int32_t) + links_.capacity() * sizeof(Link);
  }

 private:
  struct Link {
    Entry entry;
    std::int32_t next;
  };
  std::vector<std::int32_t> heads_;  ///< of the buckets: an index of links_, or -1
  std::vector<Link> links_;
  std::int32_t unused_{-1};  ///< list of links that were popped
  std::size_t cursor_{0};
  std::size_t size_{0};
  float first_key_{0};
  float per_width_{1};
};

}  // namespace extperfc::navigate
