#pragma once

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "test/unit/translate/bridge/fake_peer.hpp"
#include "translate/bridge/context.hpp"

namespace extperfc::translate::test {

/// Two fake peers and a small store: demo/Value has one field on the robot side and two on the workstation
/// side.
class BridgeFixture : public testing::Test {
 protected:
  static constexpr const char* kType = "demo/Value";

  BridgeFixture()
      : plans_(definitions_, RuleSet{}),
        context_{loop_,
                 frames_,
                 params_,
                 plans_,
                 {&robot_, &workstation_},
                 [](const std::string&) {},
                 [this](const std::string& problem) { problems_.push_back(problem); },
                 [this](Side from) { return from == Side::kRobot ? shift_ns_ : -shift_ns_; }} {
    params_.schema_patience_s = 0.05;
  }

  /// A definition that connection headers carry; known from then on.
  static SchemaPtr schema(const std::string& text, const std::string& type = kType) {
    auto parsed = parse_full_text(type, text);
    if (!parsed) throw std::runtime_error(parsed.error().message);
    return *parsed;
  }
  static ConnectionHeader publisher(const SchemaPtr& schema, const std::string& name = "/talker",
                                    bool latching = false) {
    return {{"type", schema->type()},
            {"md5sum", schema->md5()},
            {"message_definition", schema->full_text()},
            {"callerid", name},
            {"latching", latching ? "1" : "0"}};
  }
  /// As rospy asks; roscpp sends no definition.
  static ConnectionHeader subscriber(const SchemaPtr& schema, bool with_definition = true) {
    ConnectionHeader header{{"type", schema->type()}, {"md5sum", schema->md5()}, {"callerid", "/listener"}};
    if (with_definition) header["message_definition"] = schema->full_text();
    return header;
  }
  void run_for(std::chrono::milliseconds time) {
    const auto end = EventLoop::now() + time;
    while (EventLoop::now() < end) loop_.run_once(std::chrono::milliseconds(5));
  }

  const SchemaPtr robot_schema_ = schema("int32 value\n");
  const SchemaPtr workstation_schema_ = schema("int32 value\nint16 extra\n");

  EventLoop loop_;
  FramePool frames_;
  BridgeParams params_;
  DefinitionStore definitions_;
  PlanCache plans_;
  FakePeer robot_{"/bridge"}, workstation_{"/bridge"};
  std::int64_t shift_ns_{0};
  std::vector<std::string> problems_;
  BridgeContext context_;
};

}  // namespace extperfc::translate::test
