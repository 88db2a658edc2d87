#include "navigate/local/oncoming_people.hpp"

#include <algorithm>

namespace extperfc::navigate {

namespace {

constexpr float kOncoming_m_s = 0.25F;
constexpr float kWalk_s = 2.5F;     // length of a strip: where robot and person meet from 3.5 m apart
constexpr float kPassing_m = 0.45F; // comfortable, between a person's shoulder and the robot's side
constexpr float kAgainst = -0.5F;   // cosine of the angle between the path and who comes along it

}  // namespace

void OncomingPeople::set(const std::vector<MovingObstacle>& people, const Eigen::Vector2d& middle_m,
                         float inscribed_m) {
  strips_.clear();
  for (const MovingObstacle& person : people) {
    const Eigen::Vector2f velocity_m_s = person.velocity_m_s.cast<float>();
    const float speed = velocity_m_s.norm();
    if (!(speed > kOncoming_m_s)) continue;
    strips_.push_back({(person.position_m - middle_m).cast<float>(), velocity_m_s / speed, kWalk_s * speed,
                       inscribed_m + static_cast<float>(person.radius_m) + kPassing_m});
  }
}

float OncomingPeople::lack2_m2(const Eigen::Vector2f& point_m, const Eigen::Vector2f& direction) const {
  float sum = 0;
  for (const Strip& strip : strips_) {
    if (strip.heading.dot(direction) > kAgainst) continue;
    const Eigen::Vector2f from = point_m - strip.from_m;
    const float along_m = std::clamp(from.dot(strip.heading), 0.0F, strip.length_m);
    const float lack_m = strip.apart_m - (from - along_m * strip.heading).norm();
    if (lack_m > 0) sum += lack_m * lack_m;
  }
  return sum;
}

}  // namespace extperfc::navigate
