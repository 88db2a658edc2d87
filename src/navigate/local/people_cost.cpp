#include "navigate/local/people_cost.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::navigate {

namespace {

constexpr float kSide_m = 0.25F;      // standard deviation of discomfort beside and behind a person
constexpr float kFront_s = 0.7F;      // the same in front, as the distance walked in this time
constexpr float kSpread_m_s = 0.12F;  // growth of a position's uncertainty
constexpr float kMaxSpread_m = 0.25F;
constexpr float kCutOff = 3.0F;  // standard deviations

}  // namespace

void PeopleCost::set(const std::vector<MovingObstacle>& people, const Eigen::Vector2d& middle_m, float body_m,
                     float inscribed_m, int steps, float step_s) {
  persons_ = people.size();
  places_.clear();
  for (int step = 0; step < steps; ++step)
    for (const MovingObstacle& person : people) {
      const float time_s = static_cast<float>(step + 1) * step_s;
      const Eigen::Vector2f at_m =
          (person.position_m - middle_m).cast<float>() + time_s * person.velocity_m_s.cast<float>();
      const auto speed = static_cast<float>(person.velocity_m_s.norm());
      const float spread_m = speed > 0.1F ? std::min(kMaxSpread_m, kSpread_m_s * time_s) : 0.0F;
      Place place;
      place.x = at_m.x();
      place.y = at_m.y();
      if (speed > 0.1F) {
        place.heading_x = static_cast<float>(person.velocity_m_s.x()) / speed;
        place.heading_y = static_cast<float>(person.velocity_m_s.y()) / speed;
      }
      const auto radius_m = static_cast<float>(person.radius_m);
      place.touch2_m2 = (inscribed_m + radius_m + 0.05F) * (inscribed_m + radius_m + 0.05F);
      place.body_m = body_m + radius_m;
      const float side_m = kSide_m + spread_m;
      const float front_m = side_m + kFront_s * std::min(speed, 1.5F);
      place.inverse_side_m = 1 / side_m;
      place.inverse_front_m = 1 / front_m;
      const float far_m = place.body_m + kCutOff * front_m;
      place.far2_m2 = far_m * far_m;
      places_.push_back(place);
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
