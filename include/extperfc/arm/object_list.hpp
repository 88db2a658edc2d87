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
  int confirm{3};          ///< detections before an object is listed, [1, 100]
  double max_age_s{30.0};  ///< objects not seen for longer are removed, [0, 1e6]; 0: never
  double match_m{0.08};    ///< a detection of the class within this distance is the same object, [0.001, 10]
  int max_objects{50};     ///< maximum number of listed objects, and of waiting ones, [1, 500]
  double min_change_m{0.001};   ///< smaller changes of position or size are not reported, [0, 1]
  double min_change_rad{0.02};  ///< smaller rotations are not reported, [0, 3.15]
  int average{10};              ///< maximum number of detections in the mean, [1, 1000]
  double new_score{0.5};        ///< detections below move objects but do not add any, [0, 1]

  [[nodiscard]] Result<void> validate() const;
};

/// One detection of an object; finite, sizes above 0.
struct ObjectDetection {
  std::string label;      ///< its class, not empty
  UprightBox box;         ///< in the world's frame
  bool ambiguous{false};  ///< its pose is not reliable, e.g. because the robot hides a part
  double score{1.0};      ///< confidence, [0, 1]
};

/// An object of the scene as input of the list.
struct KnownObject {
  std::string name;
  std::string label;
  Pose world_T_object{Pose::Identity()};
  bool listed{false};  ///< it came from the list
  /// Detections must neither move nor duplicate it: a gripper holds it or is about to grasp it, or another
  /// caller owns it.
  bool still{false};
  /// Of a held object: other positions where it may be detected, e.g. the gripper's, in the world's frame.
  /// Detections of any class near them belong to it.
  std::vector<Eigen::Vector3d> places;
};

struct ListedObject {
  std::string name;  ///< <label>_<n>, n from 1; the same as long as the object is listed
  std::string label;
  Pose world_T_object{Pose::Identity()};  ///< of the centre
  Eigen::Vector3d size_m{Eigen::Vector3d::Zero()};
};

/// Result of one update.
struct ObjectListUpdate {
  int matched{0};       ///< detections of known objects
  int claimed{0};       ///< detections of objects that must not change
  int ambiguous{0};     ///< ambiguous detections that match no object
  int duplicate{0};     ///< detections inside another detected object
  int no_room{0};       ///< detections dropped because of max_objects
  int waiting{0};       ///< objects with too few detections so far
  bool changed{false};  ///< an object was added, removed, or changed
  int doubtful{0};      ///< detections below new_score that match no object
};

/// Tracks objects over the detections of successive images: association, pose, size, and removal.
///
/// A detection belongs to the nearest object of its class within match_m of its last position, nearest pairs
/// first. Pose and size are means over the latest detections; of a box's four equivalent yaw angles the one
/// nearest to the mean is used, with x and y exchanged if necessary. Detections farther than half of match_m
/// from the mean start a new mean when `confirm` of them arrive in a row. An object that is detected inside
/// another one, nearer to its centre than half of its shortest edge, is ignored while the other one is
/// detected, and replaces it otherwise. An ambiguous detection is matched after all others; it neither adds
/// nor moves an object, but prevents a matching object from expiring. A detection below new_score moves a
/// listed object, but neither begins one nor counts towards `confirm`: of the robot's own parts a detector is
/// rarely sure, again and again. An object that is not detected `confirm` times in a row before it is listed
/// is dropped. Deterministic; not thread-safe; holds at most 2 max_objects.
class ObjectList {
 public:
  /// Errors: parameters out of their ranges.
  [[nodiscard]] static Result<ObjectList> make(const ObjectListParams& params);

  /// Processes the detections of one image taken at `time_s`; when time goes back, all objects count as seen
  /// at that time. `scene` contains all objects of the scene: listed objects that are missing there, or
  /// belong to another caller, are dropped; objects that were moved there are updated. O(objects x
  /// detections).
  ObjectListUpdate update(const std::vector<ObjectDetection>& detections,
                          const std::vector<KnownObject>& scene, double time_s);

  [[nodiscard]] std::vector<ListedObject> objects() const;
  /// Drops all objects, e.g. when the frame changes.
  void clear() { tracks_.clear(); }

 private:
  struct Track {
    std::string name;  ///< empty until it is listed
    std::string label;
    UprightBox mean;
    int count{0};  ///< detections in the mean; 0: moved by a caller
    int far{0};    ///< latest detections far from the mean
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
  void see(Track& track, const ObjectDetection& detection, double time_s) const;
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
