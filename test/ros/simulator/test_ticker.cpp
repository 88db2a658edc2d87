#include <gtest/gtest.h>

#include "ros/simulate/ticker.hpp"

namespace extperfc::ros_simulate {
namespace {

/// How often the ticker is due while `steps` steps of 1 / step_hz pass.
int count_due(Ticker& ticker, int steps, double step_hz) {
  int due = 0;
  for (int i = 1; i <= steps; ++i) due += ticker.due(i / step_hz) ? 1 : 0;
  return due;
}

TEST(Ticker, KeepsItsRateWhateverTheStep) {
  for (const double step_hz : {240.0, 500.0, 1000.0})
    for (const double rate_hz : {1.0, 10.0, 15.0, 50.0, 100.0, 120.0}) {
      Ticker ticker(rate_hz);
      EXPECT_EQ(count_due(ticker, static_cast<int>(step_hz) * 10, step_hz), static_cast<int>(rate_hz) * 10)
          << rate_hz << " Hz in steps of 1/" << step_hz << " s";
    }
}

TEST(Ticker, IsDueAtTheMultiplesAndNotAtTheStart) {
  Ticker ticker(10.0);
  EXPECT_FALSE(ticker.due(0.0));
  EXPECT_FALSE(ticker.due(0.099));
  EXPECT_TRUE(ticker.due(0.1));
  EXPECT_FALSE(ticker.due(0.15));
  EXPECT_TRUE(ticker.due(0.2));
}

TEST(Ticker, SumsOfStepsDoNotMissAMultiple) {
  Ticker ticker(10.0);
  double time_s = 0.0;
  int due = 0;
  for (int i = 0; i < 240; ++i) due += ticker.due(time_s += 1.0 / 240.0) ? 1 : 0;
  EXPECT_EQ(due, 10);
}

TEST(Ticker, RateAboveTheStepsIsTheStepsRate) {
  Ticker ticker(1000.0);
  EXPECT_EQ(count_due(ticker, 240, 240.0), 240);
}

TEST(Ticker, ZeroIsNever) {
  Ticker ticker(0.0);
  EXPECT_EQ(count_due(ticker, 1000, 240.0), 0);
}

TEST(Ticker, TimeThatGoesBackStartsAnew) {
  Ticker first(15.0);
  const int before = count_due(first, 100, 240.0);
  EXPECT_EQ(count_due(first, 100, 240.0), before) << "a second run is due at the same steps as the first";
}

}  // namespace
}  // namespace extperfc::ros_simulate
