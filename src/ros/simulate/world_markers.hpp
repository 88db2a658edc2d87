#pragma once

#include <vector>

#include <ros/time.h>
#include <visualization_msgs/MarkerArray.h>

#include "extperfc/simulate/simulator.hpp"
#include "extperfc/simulate/world_spec.hpp"

namespace extperfc::ros_simulate {

/// The simulated world as rviz markers in the frame `map`: one marker per shape, people as figures.
/// Not thread-safe.
class WorldMarkers {
 public:
  explicit WorldMarkers(const simulate::WorldSpec& world);

  /// Everything, at its poses of the snapshot.
  [[nodiscard]] visualization_msgs::MarkerArray all(const simulate::Snapshot& snapshot,
                                                    const ros::Time& stamp) const;
  /// What moved by more than a millimetre or a tenth of a degree since the last call, which remembers.
  [[nodiscard]] visualization_msgs::MarkerArray moved(const simulate::Snapshot& snapshot,
                                                      const ros::Time& stamp);

 private:
  /// A marker and what carries it.
  struct Part {
    visualization_msgs::Marker marker;
    Pose carrier_T_part;
  };
  /// A body or a person.
  struct Carrier {
    std::vector<Part> parts;
    Pose shown{Pose::Identity()};  ///< where moved() reported it last
  };

  void add_body(const simulate::BodySpec& body);
  void add_person(const simulate::PersonSpec& person);
  void add_part(Carrier& carrier, visualization_msgs::Marker marker, const Pose& carrier_T_part,
                const std::string& ns);
  [[nodiscard]] std::vector<Pose> poses(const simulate::Snapshot& snapshot) const;
  static void append(const Carrier& carrier, const Pose& map_T_carrier, const ros::Time& stamp,
                     visualization_msgs::MarkerArray& array);

  std::vector<Carrier> carriers_;  ///< bodies, then people
  int next_id_{0};
};

}  // namespace extperfc::ros_simulate
