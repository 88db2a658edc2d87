#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/bridge.hpp"

namespace extperfc::ros_params {

/// Sources of definitions: of services, and of types that no connection has defined yet.
struct TranslatorDefinitions {
  bool shipped{true};    ///< config/translate/definitions of this package: Indigo, Noetic, Baxter's SDK
  bool installed{true};  ///< every package on the node's ROS_PACKAGE_PATH, as the set "installed"
  struct Folder {
    std::filesystem::path folder;  ///< of packages with msg/, srv/, action/
    std::string set;               ///< that they become
    std::string fallback;          ///< set for what they embed and do not have
  };
  std::vector<Folder> folders;
};

struct TranslatorRules {
  bool shipped{true};                        ///< config/translate/*.yaml of this package
  std::vector<std::filesystem::path> files;  ///< more; a folder stands for its *.yaml in the order of names
};

struct TranslatorDiagnostics {
  double period_s{1.0};        ///< of the link's status, [0.1, 3600]
  double topic_period_s{4.0};  ///< of the topics' and services', [0.1, 3600]; aggregators call 5 s stale
  int max_items{200};          ///< topics and services in one report, the worst first, [0, 10000]
};

struct TranslatorParams {
  translate::BridgeParams bridge;
  TranslatorDefinitions definitions;
  TranslatorRules rules;
  TranslatorDiagnostics diagnostics;
  double shut_down_patience_s{3.0};  ///< for the masters' answers at the end, [0, 60]
};

/// Reads `private_handle`; every problem is reported at once. `node_name` is the home node's own.
[[nodiscard]] Result<TranslatorParams> load_translator_params(const ros::NodeHandle& private_handle,
                                                              const std::string& node_name);

}  // namespace extperfc::ros_params
