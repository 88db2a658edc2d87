#pragma once

#include <filesystem>
#include <fstream>

#include "extperfc/base/error.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::benchmark {

/// A CARMEN log of ROBOTLASER1 lines without remissions.
class CarmenWriter {
 public:
  explicit CarmenWriter(const std::filesystem::path& file) : file_(file), out_(file) {}

  void add(const LaserScan& scan, const Pose2& odom_T_base);
  /// Errors: the file cannot be written.
  [[nodiscard]] Result<void> finish();

 private:
  std::filesystem::path file_;
  std::ofstream out_;
};

}  // namespace extperfc::benchmark
