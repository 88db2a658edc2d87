#include "ros/mapping/people_filter.hpp"

#include <cmath>
#include <utility>

namespace extperfc::ros_mapping {

namespace {

constexpr double kOldS = 1.0;
constexpr double kMarginM = 0.2;  // about a person: arms, and a step
constexpr double kWalks = 0.5;    // score of who walks, at least

}  // namespace

void PeopleFilter::add(const TrackArray& message) {
  std::vector<Person> people;
  if (message.header.frame_id == odom_frame_)
    for (const auto& track : message.tracks) {
      const auto& position = track.pose.pose.position;
      const Person person{
          {position.x, position.y}, {track.velocity.x, track.velocity.y}, 0.5 * track.size.x + kMarginM};
      const bool finite = person.position_m.allFinite() && person.velocity_m_s.allFinite();
      if (track.score >= kWalks && finite) people.push_back(person);
    }
  const std::lock_guard lock(mutex_);
  stamp_s_ = message.header.stamp.toSec();
  people_ = std::move(people);
}

LaserScan PeopleFilter::without_people(LaserScan scan, const Pose2& odom_T_base) {
  std::vector<Disc> discs;
  {
    const std::lock_guard lock(mutex_);
    const double later_s = scan.stamp_s - stamp_s_;
    if (people_.empty() || std::abs(later_s) > kOldS) return scan;
    for (const Person& person : people_)
      discs.push_back({person.position_m + later_s * person.velocity_m_s, person.radius_m});
  }
  const std::size_t all = count_returns(scan);
  const Pose2 odom_T_scanner = compose(odom_T_base, scan.base_T_sensor);
  scan = without_discs(std::move(scan), discs, odom_T_scanner);
  left_out_ += all - count_returns(scan);
  return scan;
}

}  // namespace extperfc::ros_mapping
