#include "extperfc/world/trajectory.hpp"

#include <array>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <locale>
#include <sstream>
#include <string>

#include "extperfc/base/atomic_file.hpp"
#include "extperfc/base/number_reader.hpp"

namespace extperfc {

namespace {

constexpr std::size_t kColumns = 8;

/// x y yaw of one line; `stamp x y z qx qy qz qw`, more columns are ignored.
Result<StampedPose2> parse_line(const std::string& line) {
  TokenReader in(line);
  std::array<double, kColumns> value{};
  for (auto& number : value) {
    const auto read = in.number();
    if (!read)
      return fail(ErrorCode::kCorrupt,
                  "expected 'stamp x y z qx qy qz qw', found '" + line.substr(0, 80) + "'");
    number = *read;
  }
  const auto [stamp_s, x, y, z, qx, qy, qz, qw] = value;
  const double norm = std::sqrt(qx * qx + qy * qy + qz * qz + qw * qw);
  constexpr double kNormTolerance = 0.01;
  if (std::abs(norm - 1.0) > kNormTolerance)
    return fail(ErrorCode::kCorrupt, "the quaternion of '" + line.substr(0, 80) + "' is not of length 1");
  const double yaw = std::atan2(2 * (qw * qz + qx * qy), qw * qw + qx * qx - qy * qy - qz * qz);
  return StampedPose2{stamp_s, {x, y, yaw}};
}

}  // namespace

Result<void> write_tum(const Trajectory& trajectory, const std::filesystem::path& file) {
  return write_file_atomically(file, [&](std::ostream& out) {
    out << "# stamp x y z qx qy qz qw\n" << std::fixed;
    for (const auto& [stamp_s, pose] : trajectory)
      out << std::setprecision(9) << stamp_s << ' ' << pose.x << ' ' << pose.y << " 0 0 0 "
          << std::setprecision(12) << std::sin(pose.yaw / 2) << ' ' << std::cos(pose.yaw / 2) << '\n';
  });
}

Result<Trajectory> read_tum(const std::filesystem::path& file) {
  std::error_code ignored;
  std::ifstream in(file);
  if (!in || std::filesystem::is_directory(file, ignored))
    return fail(ErrorCode::kNotFound, "cannot read the trajectory " + file.string());
  Trajectory trajectory;
  std::size_t number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const auto first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    const auto pose = parse_line(line);
    if (!pose)
      return fail(pose.error().code,
                  file.string() + " line " + std::to_string(number) + ": " + pose.error().message);
    trajectory.push_back(*pose);
  }
  if (in.bad()) return fail(ErrorCode::kFailed, "cannot read " + file.string() + " to its end");
  return trajectory;
}

}  // namespace extperfc
