#include "navigate/local/people_cost.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace extperfc::navigate {

namespace {

constexpr float kSide_m = 0.25F;      // standard deviation of discomfort beside and behind a person
constexpr float kFront_s = 0.7F;      // the same in front, as the distance walked in this time
constexpr float kSpread_m_s = 0.12F;  // growth of a position's uncertainty
constexpr float kMaxSpread_m = 0.25F;
constexpr float kCutOff = 3.0F;  // standard deviations
constexpr float kWalks_m_s = 0.1F;
constexpr float kStops_m = 0.25F;  // between a person and a robot that stands in the path

/// How far a person at `at_m` about the robot's middle walks along `heading` until the robot, as large as it
/// is now, is in the path.
float free_walk_m(const Eigen::Vector2f& at_m, const Eigen::Vector2f& heading, float touch_m, float stop_m) {
  const float along_m = -at_m.dot(heading);
  const float across_m = std::abs(at_m.x() * heading.y() - at_m.y() * heading.x());
  if (along_m <= 0 || across_m >= touch_m) return std::numeric_limits<float>::infinity();
  return std::max(0.0F, along_m - std::sqrt(stop_m * stop_m - across_m * across_m));
}

}  // namespace

void PeopleCost::set(const std::vector<MovingObstacle>& people, const Eigen::Vector2d& middle_m, float body_m,
                     float inscribed_m, int steps, float step_s) {
  persons_ = people.size();
  places_.resize(persons_ * static_cast<std::size_t>(steps));
  for (std::size_t i = 0; i < persons_; ++i) {
    const MovingObstacle& person = people[i];
    const Eigen::Vector2f from_m = (person.position_m - middle_m).cast<float>();
    const auto radius_m = static_cast<float>(person.radius_m);
    const auto speed = static_cast<float>(person.velocity_m_s.norm());
    const bool walks = speed > kWalks_m_s;
    const Eigen::Vector2f heading =
        walks ? Eigen::Vector2f(person.velocity_m_s.cast<float>() / speed) : Eigen::Vector2f(0, 0);
    const float touch_m = inscribed_m + radius_m + 0.05F;
    const float until_m = walks ? free_walk_m(from_m, heading, touch_m, body_m + radius_m + kStops_m) : 0.0F;
    for (int step = 0; step < steps; ++step) {
      const float time_s = static_cast<float>(step + 1) * step_s;
      const bool stopped = time_s * speed >= until_m;
      const float spread_m = walks ? std::min(kMaxSpread_m, kSpread_m_s * time_s) : 0.0F;
      const Eigen::Vector2f at_m = from_m + std::min(time_s * speed, until_m) * heading;
      Place& place = places_[static_cast<std::size_t>(step) * persons_ + i];
      place.x = at_m.x();
      place.y = at_m.y();
      place.heading_x = heading.x();
      place.heading_y = heading.y();
      place.touch2_m2 = touch_m * touch_m;
      place.body_m = body_m + radius_m;
      const float side_m = kSide_m + spread_m;
      const float front_m = side_m + (stopped ? 0.0F : kFront_s * std::min(speed, 1.5F));
      place.inverse_side_m = 1 / side_m;
      place.inverse_front_m = 1 / front_m;
      const float far_m = place.body_m + kCutOff * front_m;
      place.far2_m2 = far_m * far_m;
    }
  }
}

float PeopleCost::at(std::size_t step, float x_m, float y_m) const {
  float sum = 0;
  const Place* place = places_.data() + step * persons_;
  for (std::size_t i = 0; i < persons_; ++i, ++place) {
    const float dx = x_m - place->x;
    const float dy = y_m - place->y;
    const float distance2 = dx * dx + dy * dy;
    if (distance2 > place->far2_m2) continue;
    if (distance2 < place->touch2_m2) sum += kTouches;
    const float distance = std::sqrt(distance2) + 1e-6F;
    const float gap = std::max(0.0F, distance - place->body_m) / distance;
    const float ahead = gap * (dx * place->heading_x + dy * place->heading_y);
    const float beside2 = gap * gap * distance2 - ahead * ahead;
    const float scaled = ahead * (ahead > 0 ? place->inverse_front_m : place->inverse_side_m);
    const float exponent =
        0.5F * (scaled * scaled + std::max(0.0F, beside2) * place->inverse_side_m * place->inverse_side_m);
    sum += exponent < 5 ? std::exp(-exponent) : 0.0F;
  }
  return sum;
}

}  // namespace extperfc::navigate
