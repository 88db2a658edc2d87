#include "test/benchmark/translate/conversion_cases.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <map>
#include <utility>

#include "extperfc/translate/definition_store.hpp"
#include "extperfc/translate/plan.hpp"
#include "extperfc/translate/rules.hpp"

namespace extperfc::benchmark {

namespace {

using namespace translate;
using Clock = std::chrono::steady_clock;

/// Counts of arrays by their path without indices, e.g. "goal_constraints.joint_constraints"; others are
/// empty.
using Counts = std::map<std::string, std::uint32_t>;

/// A message whose arrays have the sizes asked for, with plausible names and numbers.
class SizedMessage {
 public:
  explicit SizedMessage(Counts counts) : counts_(std::move(counts)) {}

  [[nodiscard]] ByteBuffer make(const MessageSchema& schema) {
    ByteBuffer out;
    append(schema, "", out);
    return out;
  }

 private:
  void append(const MessageSchema& schema, const std::string& prefix, ByteBuffer& out) {
    for (const auto& field : schema.fields()) append(field, prefix + field.name, out);
  }

  void append(const Field& field, const std::string& path, ByteBuffer& out) {
    std::uint32_t count = field.arity == Arity::kFixed ? field.fixed_count : 1;
    if (field.arity == Arity::kVariable) {
      const auto found = counts_.find(path);
      count = found == counts_.end() ? 0 : found->second;
      out.append(&count, sizeof count);
    }
    const auto size = size_of(field.primitive);
    for (std::uint32_t i = 0; i < count; ++i) {
      if (field.message) append(*field.message, path + ".", out);
      if (field.primitive == Primitive::kString) append_name(i, out);
      if (size) append_number(*size, out);
    }
  }

  static void append_name(std::uint32_t index, ByteBuffer& out) {
    const std::string name = "joint_name_" + std::to_string(index % 10);
    const auto size = static_cast<std::uint32_t>(name.size());
    out.append(&size, sizeof size);
    out.append(name.data(), size);
  }

  void append_number(std::size_t size, ByteBuffer& out) {
    const std::uint64_t bits = 0x3FB0'0000'0000'0000U + ++number_;  // about 1/16 as a float64
    out.append(&bits, size);
  }

  Counts counts_;
  std::uint64_t number_{0};
};

struct Case {
  std::string name;
  SchemaPtr from, to;
  PlanOptions options;
  Counts counts;
};

struct Timing {
  double median_ns{0}, worst_ns{0};
};

Timing timing_of(std::vector<double>& batches) {
  std::sort(batches.begin(), batches.end());
  return {batches[batches.size() / 2], batches.back()};
}

template <typename Work>
double batch_ns(int repetitions, const Work& work) {
  const auto start = Clock::now();
  for (int i = 0; i < repetitions; ++i) work();
  const auto taken = std::chrono::duration<double, std::nano>(Clock::now() - start).count();
  return taken / repetitions;
}

Result<ConversionTime> time_case(const Case& one, const RuleSet& rules) {
  constexpr int kBatches = 41;
  constexpr double kBatchBytes = 4e6;  // per batch, so that large and small messages take a similar time
  constexpr std::int64_t kShiftNs = 1'234'567'890;
  if (!one.from || !one.to) return fail(ErrorCode::kNotFound, one.name + ": no such definition in the store");
  const auto plan = Plan::compile(one.from, one.to, rules, one.options);
  if (!plan) return tl::unexpected<Error>(plan.error());
  const auto message = SizedMessage(one.counts).make(*one.from);
  ByteBuffer out;
  if (auto first = (*plan)->convert(message.view(), out, kShiftNs); !first)
    return tl::unexpected<Error>(first.error());
  ConversionTime time{one.name, to_string((*plan)->kind()), message.size(), out.size()};
  const auto convert = [&] {
    out.clear();
    (void)(*plan)->convert(message.view(), out, kShiftNs);
  };
  const auto copy = [&] {
    out.clear();
    out.append(message.data(), message.size());
    asm volatile("" : : "r"(out.data()) : "memory");  // the copy must happen
  };
  const int repetitions =
      std::max(1, static_cast<int>(kBatchBytes / static_cast<double>(message.size() + 200)));
  std::vector<double> conversions;
  std::vector<double> copies;
  for (int i = 0; i < kBatches; ++i) {
    conversions.push_back(batch_ns(repetitions, convert));
    copies.push_back(batch_ns(repetitions, copy));
  }
  const auto timing = timing_of(conversions);
  time.median_ns = timing.median_ns;
  time.worst_ns = timing.worst_ns;
  time.memcpy_ns = timing_of(copies).median_ns;
  return time;
}

/// The same definition with one more field at its end.
SchemaPtr with_added_field(const SchemaPtr& schema) {
  if (!schema) return nullptr;
  auto fields = schema->fields();
  Field added;
  added.name = "quality";
  added.written_type = "float32";
  added.primitive = Primitive::kFloat32;
  fields.push_back(std::move(added));
  return std::make_shared<const MessageSchema>(schema->type(), std::move(fields), schema->constants());
}

Counts joint_counts(const std::string& prefix, std::uint32_t joints) {
  return {{prefix + "name", joints},
          {prefix + "position", joints},
          {prefix + "velocity", joints},
          {prefix + "effort", joints}};
}

Counts motion_plan_counts() {
  auto counts = joint_counts("start_state.joint_state.", 17);
  counts["goal_constraints"] = 1;
  counts["goal_constraints.joint_constraints"] = 7;
  counts["path_constraints.orientation_constraints"] = 1;
  return counts;
}

std::vector<Case> make_cases(const DefinitionStore& store) {
  const auto noetic = [&](const char* type) { return store.message_of_set("noetic", type); };
  const auto indigo = [&](const char* type) { return store.message_of_set("indigo", type); };
  PlanOptions shift;
  shift.shift_times = true;
  auto sea_counts = joint_counts("", 7);
  sea_counts["gravity_model_effort"] = 7;
  constexpr std::uint32_t kCloudBytes = 1U << 20U;
  const auto joint_state = noetic("sensor_msgs/JointState");
  const auto cloud = noetic("sensor_msgs/PointCloud2");
  return {
      {"JointState, 17 joints, checked copy", joint_state, joint_state, {}, joint_counts("", 17)},
      {"JointState, 17 joints, shift", joint_state, joint_state, shift, joint_counts("", 17)},
      {"JointControllerState",
       indigo("control_msgs/JointControllerState"),
       noetic("control_msgs/JointControllerState"),
       {},
       {}},
      {"SEAJointState 0.7 to 1.2",
       store.message_of_set("baxter_sdk_0.7.0", "baxter_core_msgs/SEAJointState"),
       store.message_of_set("baxter_sdk_1.2.0", "baxter_core_msgs/SEAJointState"),
       {},
       sea_counts},
      {"Marker, 500 points",
       indigo("visualization_msgs/Marker"),
       noetic("visualization_msgs/Marker"),
       {},
       {{"points", 500}}},
      {"MotionPlanRequest",
       indigo("moveit_msgs/MotionPlanRequest"),
       noetic("moveit_msgs/MotionPlanRequest"),
       {},
       motion_plan_counts()},
      {"PointCloud2 of 1 MiB, field added",
       cloud,
       with_added_field(cloud),
       shift,
       {{"fields", 4}, {"data", kCloudBytes}}},
  };
}

}  // namespace

Result<std::vector<ConversionTime>> time_conversions(const std::filesystem::path& config) {
  DefinitionStore store;
  if (auto read = store.add_store(config / "definitions"); !read) return tl::unexpected<Error>(read.error());
  const auto rules = load_rules({config / "indigo_noetic.yaml", config / "baxter_sdk.yaml"}, store);
  if (!rules) return tl::unexpected<Error>(rules.error());
  std::vector<ConversionTime> times;
  for (const auto& one : make_cases(store)) {
    auto time = time_case(one, *rules);
    if (!time) return tl::unexpected<Error>(time.error());
    times.push_back(std::move(*time));
  }
  return times;
}

}  // namespace extperfc::benchmark
