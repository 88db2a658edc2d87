#pragma once

#include <string>

#include <gtest/gtest.h>

#include "extperfc/translate/plan.hpp"

#include "test/unit/translate/rules/message_text.hpp"

namespace extperfc::translate {

/// The definitions and the rules that the package ships, read once for all tests of a program.
class ShippedTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const std::string folder = std::string(EXTPERFC_SOURCE_DIR) + "/config/translate/";
    definitions = new DefinitionStore();
    const auto read = definitions->add_store(folder + "definitions");
    ASSERT_TRUE(read) << read.error().message;
    auto loaded = load_rules({folder + "indigo_noetic.yaml", folder + "baxter_sdk.yaml"}, *definitions);
    ASSERT_TRUE(loaded) << loaded.error().message;
    rules = new RuleSet(std::move(*loaded));
  }
  static void TearDownTestSuite() {
    delete rules;
    delete definitions;
    rules = nullptr;
    definitions = nullptr;
  }
  void SetUp() override { ASSERT_NE(rules, nullptr) << "the rules did not load"; }

  /// A message of a set, or a half of one of its services ("pkg/NameRequest").
  [[nodiscard]] static SchemaPtr schema(const std::string& set, const std::string& type) {
    if (auto message = definitions->message_of_set(set, type)) return message;
    for (const std::string half : {"Request", "Response"}) {
      if (type.size() < half.size() || type.substr(type.size() - half.size()) != half) continue;
      const auto service = definitions->service_of_set(set, type.substr(0, type.size() - half.size()));
      if (service) return half == "Request" ? service->request : service->response;
    }
    return nullptr;
  }

  /// Converts a message written in YAML from one set's version to another's, and compares.
  static void expect_becomes(const std::string& type, const std::string& from_set, const std::string& from,
                             const std::string& to_set, const std::string& to) {
    SCOPED_TRACE(type + " of " + from_set + " to " + to_set);
    const auto source = schema(from_set, type), target = schema(to_set, type);
    ASSERT_TRUE(source && target);
    ASSERT_NE(source->md5(), target->md5()) << "nothing changed";
    const auto plan = Plan::compile(source, target, *rules);
    ASSERT_TRUE(plan) << plan.error().message;
    const ByteBuffer message = encode(source, from), expected = encode(target, to);
    ByteBuffer converted;
    const auto done = (*plan)->convert(message.view(), converted);
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(MessageText::of(*target, converted.view()), MessageText::of(*target, expected.view()));
    EXPECT_EQ(std::string(reinterpret_cast<const char*>(converted.data()), converted.size()),
              std::string(reinterpret_cast<const char*>(expected.data()), expected.size()));
  }
  static void expect_both_directions(const std::string& type, const std::string& old_set,
                                     const std::string& old_text, const std::string& new_set,
                                     const std::string& new_text) {
    expect_becomes(type, old_set, old_text, new_set, new_text);
    expect_becomes(type, new_set, new_text, old_set, old_text);
  }
  static void expect_pass(const std::string& type, const std::string& old_set, const std::string& new_set) {
    for (const auto& [from, to] : {std::pair(old_set, new_set), std::pair(new_set, old_set)}) {
      const auto plan = Plan::compile(schema(from, type), schema(to, type), *rules);
      ASSERT_TRUE(plan) << plan.error().message;
      EXPECT_EQ((*plan)->kind(), Plan::Kind::kPass) << type << " of " << from << " to " << to;
    }
  }

  static inline DefinitionStore* definitions = nullptr;
  static inline RuleSet* rules = nullptr;
};

}  // namespace extperfc::translate
