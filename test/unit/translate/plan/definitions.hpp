#pragma once

#include <map>
#include <stdexcept>
#include <string>

#include "extperfc/translate/schema.hpp"

namespace extperfc::translate {

/// Definitions of one test: each may embed those defined before it.
class Definitions {
 public:
  SchemaPtr define(const std::string& type, const std::string& text) {
    const auto find = [this](const std::string& embedded) {
      const auto found = known_.find(embedded);
      return found == known_.end() ? SchemaPtr() : found->second;
    };
    auto schema = parse_message(type, text, find);
    if (!schema) throw std::invalid_argument(schema.error().message);
    return known_[type] = *schema;
  }

  /// std_msgs/Header, geometry_msgs/Point, Quaternion and Pose.
  void define_common() {
    define("std_msgs/Header", "uint32 seq\ntime stamp\nstring frame_id");
    define("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z");
    define("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w");
    define("geometry_msgs/Pose", "Point position\nQuaternion orientation");
  }

 private:
  std::map<std::string, SchemaPtr> known_;
};

}  // namespace extperfc::translate
