// Errors about bad input neither vanish nor bury the log.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "ros/robot/complaints.hpp"

namespace extperfc::ros_robot {
namespace {

using std::chrono::milliseconds;

TEST(Complaints, TheFirstIsReportedAtOnceAndOnePerSecondAfterwards) {
  std::vector<std::string> lines;
  Complaints complaints([&](const std::string& line) { lines.push_back(line); });
  const auto begin = Complaints::Clock::time_point{};
  for (int i = 0; i < 250; ++i) complaints.report("wrong", begin + milliseconds(10 * i));
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[0], "wrong");
  EXPECT_EQ(lines[1], "wrong (and 99 like it)");
  EXPECT_EQ(lines[2], "wrong (and 99 like it)");
}

TEST(Complaints, RareOnesAreAllReported) {
  std::vector<std::string> lines;
  Complaints complaints([&](const std::string& line) { lines.push_back(line); });
  const auto begin = Complaints::Clock::time_point{};
  complaints.report("one", begin);
  complaints.report("two", begin + milliseconds(1000));
  EXPECT_EQ(lines, (std::vector<std::string>{"one", "two"}));
}

}  // namespace
}  // namespace extperfc::ros_robot
