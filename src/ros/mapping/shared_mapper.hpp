#pragma once

#include <mutex>
#include <utility>

#include "extperfc/mapping/mapper.hpp"

namespace extperfc::ros_mapping {

/// The mapper with a mutex, for the worker that adds scans and for threads that read its results.
class SharedMapper {
 public:
  explicit SharedMapper(mapping::Mapper mapper) : mapper_(std::move(mapper)) {}

  /// Calls `use(mapper)` with the mutex locked. Keep it short: scans wait.
  template <typename Use>
  auto with(Use&& use) {
    const std::lock_guard lock(mutex_);
    return std::forward<Use>(use)(mapper_);
  }

  void replace(mapping::Mapper mapper) {
    const std::lock_guard lock(mutex_);
    std::swap(mapper_, mapper);
  }  // the old map is freed here, after the lock

 private:
  std::mutex mutex_;
  mapping::Mapper mapper_;
};

}  // namespace extperfc::ros_mapping
