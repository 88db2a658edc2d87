// Bytes that no honest sender makes: never a crash, always an error or a message of the target.
#include <algorithm>
#include <chrono>
#include <cstring>
#include <memory>

#include <gtest/gtest.h>

#include "test/support/random_message.hpp"
#include "test/unit/translate/plan/bytes_of.hpp"
#include "test/unit/translate/plan/definitions.hpp"
#include "test/unit/translate/plan/random_schema.hpp"

using namespace extperfc;
using namespace extperfc::translate;

namespace {

/// A copy on the heap without spare bytes, so that AddressSanitizer sees a read beyond the end.
bool converts(const Plan& plan, const std::string& message) {
  const auto exact = std::make_unique<std::uint8_t[]>(message.size());
  std::copy(message.begin(), message.end(), exact.get());
  ByteBuffer out;
  return plan.convert({exact.get(), message.size()}, out, 1'000).has_value();
}

bool walk(const MessageSchema& schema, const std::string& bytes, std::size_t& at);

bool walk_element(const Field& field, const std::string& bytes, std::size_t& at) {
  if (field.message) return walk(*field.message, bytes, at);
  std::uint32_t size = static_cast<std::uint32_t>(size_of(field.primitive).value_or(4));
  if (field.primitive == Primitive::kString) {
    if (bytes.size() - at < 4) return false;
    std::memcpy(&size, bytes.data() + at, sizeof size);
    at += 4;
  }
  if (bytes.size() - at < size) return false;
  at += size;
  return true;
}

bool walk(const MessageSchema& schema, const std::string& bytes, std::size_t& at) {
  for (const auto& field : schema.fields()) {
    std::uint32_t count = field.arity == Arity::kFixed ? field.fixed_count : 1;
    if (field.arity == Arity::kVariable) {
      if (bytes.size() - at < 4) return false;
      std::memcpy(&count, bytes.data() + at, sizeof count);
      at += 4;
    }
    if (field.message && field.message->min_size() == 0) continue;  // any number of nothing
    for (std::uint32_t i = 0; i < count; ++i)
      if (!walk_element(field, bytes, at)) return false;
  }
  return true;
}

bool is_message_of(const MessageSchema& schema, const std::string& bytes) {
  std::size_t at = 0;
  return walk(schema, bytes, at) && at == bytes.size();
}

/// Definitions that the parser would refuse; plans must bear them too.
Field field_of(Primitive primitive, const std::string& name, std::uint32_t fixed_count = 0) {
  Field field;
  field.name = name;
  field.primitive = primitive;
  field.written_type = to_string(primitive);
  field.arity = fixed_count == 0 ? Arity::kSingle : Arity::kFixed;
  field.fixed_count = fixed_count;
  return field;
}

Field field_of(const SchemaPtr& message, const std::string& name, std::uint32_t fixed_count = 0) {
  auto field = field_of(Primitive::kMessage, name, fixed_count);
  field.message = message;
  field.written_type = message->type();
  return field;
}

SchemaPtr message_of(std::vector<Field> fields) {
  return std::make_shared<const MessageSchema>("p/Made", std::move(fields), std::vector<Constant>());
}

PlanOptions options_for(std::uint64_t seed) {
  PlanOptions options;
  options.shift_times = seed % 2 == 0;
  options.frame_slash = static_cast<PlanOptions::Slash>(seed % 3);
  options.max_message_bytes = 1U << 20U;
  return options;
}

}  // namespace

TEST(PlanHostile, EveryTruncationIsAnError) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    RandomSchema schemas(rng);
    const auto from = schemas.make();
    const auto plan = Plan::compile(from, schemas.evolve(*from), RuleSet(), options_for(seed));
    ASSERT_TRUE(plan) << plan.error().message;
    const auto message = string_of(RandomMessage(rng, {3, 5, 0.0}).make(*from));
    for (std::size_t size = 0; size < message.size(); ++size)
      ASSERT_FALSE(converts(**plan, message.substr(0, size))) << size;
    ASSERT_FALSE(converts(**plan, message + 'x'));
  }
}

TEST(PlanHostile, RandomBytesGiveAnErrorOrAMessage) {
  int accepted = 0;
  std::chrono::steady_clock::duration slowest{0};
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    RandomSchema schemas(rng);
    const auto from = schemas.make();
    const auto plan = Plan::compile(from, schemas.evolve(*from), RuleSet(), options_for(seed));
    ASSERT_TRUE(plan) << plan.error().message;
    std::string bytes = string_of(RandomMessage(rng).make(*from));
    for (auto& byte : bytes)
      if (rng.chance(0.1))
        byte = static_cast<char>(rng.chance(0.5) ? rng.integer(0, 3) : rng.integer(0, 255));
    ByteBuffer out;
    const auto start = std::chrono::steady_clock::now();
    const auto done = (*plan)->convert(view_of(bytes), out, 1'000);
    slowest = std::max(slowest, std::chrono::steady_clock::now() - start);
    if (!done) continue;
    ++accepted;
    ASSERT_TRUE(is_message_of(*(*plan)->to(), string_of(out)));
  }
  EXPECT_LT(slowest, std::chrono::milliseconds(500));
  EXPECT_GT(accepted, 100) << "the bytes are too wild to reach anything";
}

TEST(PlanHostile, CountsAreCheckedBeforeMemoryIsTaken) {
  Definitions definitions;
  definitions.define("p/In", "uint8 a\nstring s");
  definitions.define("p/Out", "uint8 a\nstring s\nfloat64[100] more");
  const auto plan =
      Plan::compile(definitions.define("p/A", "p/In[] v"), definitions.define("p/B", "p/Out[] v"), RuleSet());
  ASSERT_TRUE(plan);
  ByteBuffer out;
  const auto done = (*plan)->convert(view_of(Bytes().count(0xFFFFFFFF).put('a').text("x").str()), out);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("field v claims 4294967295 elements"), std::string::npos)
      << done.error().message;
  EXPECT_LT(out.capacity(), 4096U);
}

TEST(PlanHostile, ConvertedMessagesAreBounded) {
  Definitions definitions;
  definitions.define("p/In", "uint8 a");
  definitions.define("p/Out", "uint8 a\nfloat64[100] more");
  PlanOptions options;
  options.max_message_bytes = 10'000;
  const auto plan = Plan::compile(definitions.define("p/A", "p/In[] v"),
                                  definitions.define("p/B", "p/Out[] v"), RuleSet(), options);
  ASSERT_TRUE(plan);
  const auto message = [](std::uint32_t count) {
    return Bytes().count(count).str() + std::string(count, 'x');
  };
  EXPECT_EQ(converted(**plan, message(12)).size(), 4 + 12 * 801U);
  EXPECT_NE(converted(**plan, message(13)).find("longer than 10000 bytes"), std::string::npos);
}

TEST(PlanHostile, ElementsWithoutBytesTakeNoTime) {
  Definitions definitions;
  definitions.define("std_msgs/Empty", "");
  definitions.define("p/Full", "float64 x");
  definitions.define("p/Hollow", "string[0] none\nstd_msgs/Empty[5] empty");
  PlanOptions options;
  options.max_message_bytes = 1U << 20U;
  const auto message = Bytes().count(0xFFFFFFFF).str();
  const auto start = std::chrono::steady_clock::now();
  for (const auto* to : {"std_msgs/Empty[] v", "p/Hollow[] v"}) {
    const auto plan = Plan::compile(definitions.define("p/A", "std_msgs/Empty[] v"),
                                    definitions.define("p/B", to), RuleSet(), options);
    ASSERT_TRUE(plan);
    EXPECT_EQ(converted(**plan, message), message);
  }
  const auto hollow = Plan::compile(definitions.define("p/A", "p/Hollow[] v"),
                                    definitions.define("p/B", "uint8 other"), RuleSet(), options);
  EXPECT_EQ(converted(**hollow, message), std::string(1, '\0'));
  const auto full = Plan::compile(definitions.define("p/A", "std_msgs/Empty[] v"),
                                  definitions.define("p/B", "p/Full[] v"), RuleSet(), options);
  ASSERT_TRUE(full);
  EXPECT_EQ(converted(**full, message).rfind("error: ", 0), 0U);
  EXPECT_EQ(converted(**full, Bytes().count(3).str()), Bytes().count(3).str() + std::string(24, '\0'));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
}

TEST(PlanHostile, DefinitionsThatMultiplyAreRefused) {
  auto below = message_of({field_of(Primitive::kString, "s")});
  for (int i = 0; i < 24; ++i) below = message_of({field_of(below, "a"), field_of(below, "b")});
  auto above = message_of({field_of(below, "d"), field_of(Primitive::kUint8, "e")});
  const auto plan = Plan::compile(message_of({field_of(below, "d")}), above, RuleSet());
  ASSERT_FALSE(plan);
  EXPECT_NE(plan.error().message.find("too large"), std::string::npos) << plan.error().message;
}

TEST(PlanHostile, HugeFixedArraysAreRefused) {
  constexpr std::uint32_t kMax = 1U << 24U;
  const auto big = message_of({field_of(Primitive::kFloat64, "v", kMax)});
  const auto bigger = message_of({field_of(big, "v", kMax)});
  const auto none = message_of({});
  for (const auto& [from, to] :
       {std::pair{none, bigger}, std::pair{bigger, none}, std::pair{bigger, bigger}}) {
    const auto plan = Plan::compile(from, to, RuleSet());
    ASSERT_FALSE(plan);
    EXPECT_NE(plan.error().message.find("max_message_bytes"), std::string::npos) << plan.error().message;
  }
}
