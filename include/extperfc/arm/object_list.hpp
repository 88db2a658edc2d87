#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/arm/upright_box.hpp"
#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::arm {

struct ObjectListParams {
  int confirm{3};          ///< sightings before an object is listed, [1, 100]
  double max_age_s{30.0};  ///< not seen for so long it is no longer listed, [0, 1e6]; 0: it stays
  double match_m{0.08};    ///< a sighting of the class within this distance is the same object, [0.001, 10]
  int max_objects{50};     ///< that are listed, and as many that wait for it, [1, 500]
  double min_change_m{0.005};   ///< a smaller motion or change of size is none, [0, 1]
  double min_change_rad{0.09};  ///< a smaller turn is none, [0, 3.15]
  int average{10};              ///< sightings that the mean goes back, [1, 1000]

  [[nodiscard]] Result<void> validate() const;
};

/// An object as one picture shows it; finite, sizes above 0.
struct ObjectDetection {
  std::string label;      ///< its class, not empty
  UprightBox box;         ///< in the world's frame
  bool ambiguous{false};  ///< something may be there, but who knows where, as when the robot hides half of it
};

/// A thing of the scene, as far as sightings concern it.
struct KnownObject {
  std::string name;
  std::string label;
  Pose world_T_object{Pose::Identity()};
  bool listed{false};  ///< it came from the list
  bool still{false};   ///< sightings must neither move nor double it: a hand holds it or grasps for it, or it
                       ///< is somebody else's
  /// Of a thing in a hand: where it may be seen too, as the hand's, in the world's frame. Sightings of any
  /// class near it are its own.
  std::vector<Eigen::Vector3d> places;
};

struct ListedObject {
  std::string name;  ///< <label>_<n>, n from 1; the same as long as the object is listed
  std::string label;
  Pose world_T_object{Pose::Identity()};  ///< of the middle
  Eigen::Vector3d size_m{Eigen::Vector3d::Zero()};
};

/// What one update came to.
struct ObjectListUpdate {
  int matched{0};       ///< sightings of known objects
  int claimed{0};       ///< sightings of things that are to be left alone
  int ambiguous{0};     ///< vague sightings of nothing that is known
  int duplicate{0};     ///< sightings inside an object that was seen as well
  int no_room{0};       ///< sightings that were dropped because there are too many objects
  int waiting{0};       ///< objects that were not seen often enough yet
  bool changed{false};  ///< an object came, went, or changed
};

/// Objects from sightings in picture after picture: which sighting is which object, where it stands, whether
/// it is there at all.
///
/// A sighting belongs to the nearest object of its class within match_m of where that was seen last, nearest
/// pairs first. Pose and size are means over the latest sightings; a box's yaw is taken as the one of its
/// four that is nearest to the mean's, with x and y exchanged where they have to be. Sightings farther than
/// half of match_m from the mean begin a new one when they have come `confirm` times in a row. An object that
/// is seen inside another one, nearer to its middle than half of its shortest edge, is none while the other
/// is seen too, and takes its place otherwise. A vague sighting is matched after all others; it makes no
/// object and moves none, but a listed one counts as seen. What was not seen `confirm` times in a row before
/// it was listed is forgotten. Deterministic; not thread-safe; holds 2 max_objects at most.
class ObjectList {
 public:
  /// Errors: parameters out of their ranges.
  [[nodiscard]] static Result<ObjectList> make(const ObjectListParams& params);

  /// Takes the sightings of one picture, which was taken at `time_s`; a time that goes back makes all objects
  /// seen then. `scene` has everything in the scene: listed objects that are missing there, or have become
  /// somebody else's, are forgotten; those that were moved there are where they were moved to.
  /// O(objects x sightings).
  ObjectListUpdate update(const std::vector<ObjectDetection>& detections,
                          const std::vector<KnownObject>& scene, double time_s);

  [[nodiscard]] std::vector<ListedObject> objects() const;
  /// For a new frame.
  void clear() { tracks_.clear(); }

 private:
  struct Track {
    std::string name;  ///< empty until it is listed
    std::string label;
    UprightBox mean;
    int count{0};  ///< sightings in the mean; 0: it was put here
    int far{0};    ///< latest sightings that did not fit the mean
    Eigen::Vector3d last_m{Eigen::Vector3d::Zero()};
    int detections{0};
    int missed{0};  ///< latest updates without it
    double seen_s{0};
    bool still{false};
    Pose shown{Pose::Identity()};
    Eigen::Vector3d shown_size_m{Eigen::Vector3d::Zero()};
  };

  explicit ObjectList(const ObjectListParams& params) : params_(params) {}
  [[nodiscard]] bool follow(const std::vector<KnownObject>& scene, double time_s);
  [[nodiscard]] std::vector<int> match(const std::vector<ObjectDetection>& detections) const;
  [[nodiscard]] bool claimed(const ObjectDetection& detection, const std::vector<KnownObject>& scene) const;
  void put(Track& track, const Pose& pose, double time_s) const;
  void see(Track& track, const UprightBox& detection, double time_s) const;
  void begin(const ObjectDetection& detection, double time_s, ObjectListUpdate& done);
  [[nodiscard]] bool leave(double time_s);
  [[nodiscard]] bool join(const std::vector<KnownObject>& scene);
  [[nodiscard]] bool show(Track& track) const;
  [[nodiscard]] std::string free_name(const std::string& label, const std::vector<KnownObject>& scene) const;
  [[nodiscard]] int count(bool listed) const;

  ObjectListParams params_;
  std::vector<Track> tracks_;  ///< in the order in which they came
};

}  // namespace extperfc::arm
