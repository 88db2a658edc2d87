#include <limits>

#include <gtest/gtest.h>

#include "ros/health/stream_health.hpp"

namespace extperfc::ros_health {
namespace {

using diagnostic_msgs::DiagnosticStatus;
constexpr double kLongS = 3600.0;
constexpr double kAtOnceS = 0.0;

std::string value(const DiagnosticStatus& status, const std::string& key) {
  for (const auto& pair : status.values)
    if (pair.key == key) return pair.value;
  return "(none)";
}

diagnostic_updater::DiagnosticStatusWrapper fresh() {
  diagnostic_updater::DiagnosticStatusWrapper status;
  status.summary(DiagnosticStatus::OK, "running");
  return status;
}

TEST(InputHealth, ReportsWhatCame) {
  InputHealth health("image");
  int payload = 0;
  auto status = fresh();
  health.report(status, "/topic", kLongS);
  EXPECT_EQ(value(status, "image transport"), "none yet");

  health.received(ros::Time(12, 345), &payload, true);
  status = fresh();
  health.report(status, "/topic", kLongS);
  EXPECT_EQ(value(status, "image topic"), "/topic");
  EXPECT_EQ(value(status, "image received"), "1");
  EXPECT_EQ(value(status, "image transport"), "pointer (no copy)");
  char expected[64];
  std::snprintf(expected, sizeof(expected), "12.000000345 @ %p", static_cast<void*>(&payload));
  EXPECT_EQ(value(status, "image last"), expected);

  health.received(ros::Time(12, 346), &payload, false);
  status = fresh();
  health.report(status, "/topic", kLongS);
  EXPECT_EQ(value(status, "image transport"), "network");
}

TEST(InputHealth, SilenceIsAFaultOnlyWhileListening) {
  InputHealth health("image");
  auto status = fresh();
  health.report(status, "/topic", kAtOnceS);
  EXPECT_EQ(status.level, DiagnosticStatus::OK);
  health.listening(true);
  status = fresh();
  health.report(status, "/topic", kAtOnceS);
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_NE(status.message.find("no message on /topic for"), std::string::npos) << status.message;
  status = fresh();
  health.report(status, "/topic", kLongS);
  EXPECT_EQ(status.level, DiagnosticStatus::OK) << "not silent for long enough";
  health.listening(false);
  status = fresh();
  health.report(status, "/topic", kAtOnceS);
  EXPECT_EQ(status.level, DiagnosticStatus::OK);
}

TEST(WorkHealth, NewErrorsAreNewOnce) {
  WorkHealth health;
  EXPECT_TRUE(health.failed("a"));
  EXPECT_FALSE(health.failed("a"));
  EXPECT_TRUE(health.failed("b"));
  EXPECT_TRUE(health.failed("a"));
  health.done(1.0, 1.0);
  EXPECT_TRUE(health.failed("a")) << "it went well in between";
}

TEST(WorkHealth, ErrorLastsUntilTheNextSuccess) {
  WorkHealth health;
  (void)health.failed("the image is empty");
  auto status = fresh();
  health.report(status);
  EXPECT_EQ(status.level, DiagnosticStatus::ERROR);
  EXPECT_NE(status.message.find("the image is empty"), std::string::npos);
  health.done(1.0, 1.0);
  status = fresh();
  health.report(status);
  EXPECT_EQ(status.level, DiagnosticStatus::OK);
  EXPECT_EQ(value(status, "processed"), "1");
  EXPECT_EQ(value(status, "failed"), "1");
}

TEST(WorkHealth, PercentilesAreOfTheLatest) {
  WorkHealth health;
  for (int i = 0; i < 1000; ++i) health.done(1000.0, 1000.0);
  for (int i = 0; i <= 300; ++i) health.done(i, 2.0 * i);  // more than are kept: 45 to 300 remain
  auto status = fresh();
  health.report(status);
  EXPECT_EQ(value(status, "processed"), "1301");
  EXPECT_NEAR(std::stod(value(status, "work median [ms]")), 172.5, 1.0);
  EXPECT_NEAR(std::stod(value(status, "latency p95 [ms]")), 2.0 * (45 + 0.95 * 255), 2.0);
}

}  // namespace
}  // namespace extperfc::ros_health
