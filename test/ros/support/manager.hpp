#pragma once

#include <map>
#include <set>
#include <string>

#include <XmlRpcValue.h>
#include <nodelet/loader.h>

namespace extperfc::ros_test {

using Params = std::map<std::string, XmlRpc::XmlRpcValue>;

/// Nodelets in the test's own process, as a nodelet manager hosts them. Unloads them all, and removes their
/// parameters, at its end.
class Manager {
 public:
  Manager() = default;
  ~Manager();
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;

  /// Sets `params` in the nodelet's private namespace, and nothing else there, and loads "extperfc/<type>".
  /// Diagnostics come as often as the nodelet can. False when the nodelet refuses.
  [[nodiscard]] bool load(const std::string& name, const std::string& type, const Params& params);
  void unload(const std::string& name);

 private:
  nodelet::Loader loader_{false};
  std::set<std::string> names_;
};

/// A folder of test/data/models.
[[nodiscard]] std::string model_folder(const std::string& name);

/// What every detector in the tests is given: the folder and one thread of OpenCV, which every build has.
[[nodiscard]] Params detector_params(const std::string& model = "square");

}  // namespace extperfc::ros_test
