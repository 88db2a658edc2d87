// Messages of strangers through plans: the first byte chooses the plan, the rest is the message.
#include <cstring>
#include <memory>

#include "extperfc/translate/plan.hpp"

#include "test/fuzz/target.hpp"

namespace extperfc::fuzz {

namespace {

using translate::ByteBuffer;
using translate::DefinitionStore;
using translate::Plan;
using translate::PlanOptions;
using translate::PlanPtr;
using translate::RuleSet;
using translate::SchemaPtr;

/// A plan, and the one that leads back.
struct Route {
  PlanPtr there, back;
};

struct Pair {
  const char* type;
  const char* from;
  const char* to;
};
/// Types whose plans have every kind of step: rules, chains, loops, maps, poses, nested arrays, stamps.
constexpr Pair kPairs[] = {
    {"baxter_core_msgs/HeadPanCommand", "baxter_sdk_0.7.0", "baxter_sdk_1.2.0"},
    {"baxter_core_msgs/NavigatorState", "baxter_sdk_0.7.0", "baxter_sdk_1.2.0"},
    {"baxter_core_msgs/NavigatorStates", "baxter_sdk_0.7.0", "baxter_sdk_1.2.0"},
    {"baxter_core_msgs/SEAJointState", "baxter_sdk_0.7.0", "baxter_sdk_1.2.0"},
    {"baxter_core_msgs/EndEffectorProperties", "baxter_sdk_1.1.1", "baxter_sdk_1.2.0"},
    {"baxter_core_msgs/EndpointStates", "baxter_sdk_0.7.0", "baxter_sdk_1.2.0"},
    {"baxter_maintenance_msgs/CalibrateArmEnable", "baxter_sdk_1.1.1", "baxter_sdk_1.2.0"},
    {"sensor_msgs/BatteryState", "indigo", "noetic"},
    {"sensor_msgs/JointState", "indigo", "noetic"},
    {"visualization_msgs/MarkerArray", "indigo", "noetic"},
    {"controller_manager_msgs/ControllerState", "indigo", "noetic"},
    {"moveit_msgs/CollisionObject", "indigo", "noetic"},
    {"moveit_msgs/PlanningScene", "indigo", "noetic"},
    {"moveit_msgs/MotionPlanRequest", "indigo", "noetic"},
    {"moveit_msgs/PickupActionResult", "indigo", "noetic"},
    {"tf2_msgs/TFMessage", "indigo", "noetic"},
};

/// As shipped, with and without changes to stamps and frames.
class Routes {
 public:
  Routes() {
    const std::string folder = std::string(EXTPERFC_SOURCE_DIR) + "/config/translate/";
    require(store_.add_store(folder + "definitions").has_value(), "the shipped definitions are read");
    const auto rules = load_rules({folder + "indigo_noetic.yaml", folder + "baxter_sdk.yaml"}, store_);
    require(rules.has_value(), "the shipped rules are read");
    PlanOptions plain;
    plain.max_message_bytes = 1U << 20U;
    PlanOptions shifted = plain;
    shifted.shift_times = true;
    shifted.frame_slash = PlanOptions::Slash::kAdd;
    PlanOptions stripped = plain;
    stripped.frame_slash = PlanOptions::Slash::kStrip;
    for (const auto& options : {plain, shifted, stripped})
      for (const Pair& pair : kPairs) add(pair, *rules, options);
    const auto older = store_.service_of_set("baxter_sdk_0.7.0", "baxter_core_msgs/SolvePositionIK");
    const auto newer = store_.service_of_set("baxter_sdk_1.2.0", "baxter_core_msgs/SolvePositionIK");
    add(older->request, newer->request, *rules, plain);
    add(older->response, newer->response, *rules, plain);
  }
  [[nodiscard]] const std::vector<Route>& list() const { return routes_; }

 private:
  void add(const Pair& pair, const RuleSet& rules, const PlanOptions& options) {
    add(store_.message_of_set(pair.from, pair.type), store_.message_of_set(pair.to, pair.type), rules,
        options);
  }
  void add(const SchemaPtr& one, const SchemaPtr& other, const RuleSet& rules, const PlanOptions& options) {
    const auto there = Plan::compile(one, other, rules, options),
               back = Plan::compile(other, one, rules, options);
    require(there && back, "the shipped pairs have plans");
    routes_.push_back({*there, *back});
    routes_.push_back({*back, *there});
  }

  DefinitionStore store_;
  std::vector<Route> routes_;
};

const std::vector<Route>& routes() {
  static const Routes kRoutes;
  return kRoutes.list();
}

/// A checked copy: what a plan wrote must be a message of its target.
PlanPtr reader_of(const SchemaPtr& schema) {
  static std::map<const translate::MessageSchema*, PlanPtr> known;
  PlanPtr& plan = known[schema.get()];
  if (!plan) plan = *Plan::compile(schema, schema, RuleSet());
  return plan;
}

}  // namespace

void run(std::string_view input) {
  if (input.empty()) return;
  const auto choice = static_cast<std::uint8_t>(input.front());
  const Route& route = routes()[choice % routes().size()];
  // A copy without spare bytes behind it: the sanitizer sees every byte that is read beyond the end.
  const std::size_t size = input.size() - 1;
  const std::unique_ptr<std::uint8_t[]> bytes(new std::uint8_t[size]);
  std::memcpy(bytes.get(), input.data() + 1, size);
  constexpr std::int64_t kShiftNs = -1'500'000'000;
  ByteBuffer out;
  out.append("before", 6);
  const auto done = route.there->convert({bytes.get(), size}, out, kShiftNs);
  require(out.size() >= 6 && std::memcmp(out.data(), "before", 6) == 0, "what was in the buffer stays");
  if (!done) {
    require(out.size() == 6 && !done.error().message.empty(), "a refusal has a reason and leaves nothing");
    return;
  }
  require(out.size() <= 6 + (1U << 20U), "a converted message keeps within its bound");
  const translate::ByteView converted{out.data() + 6, out.size() - 6};
  ByteBuffer copy, back;
  require(reader_of(route.there->to())->convert(converted, copy).has_value(),
          "what was converted is a message");
  require(copy.size() == converted.size, "a checked copy has the same size");
  if (!route.back->convert(converted, back, -kShiftNs))
    return;  // a number may not fit back: a speed of 3e9 is no int32
  require(reader_of(route.back->to())->convert(back.view(), copy).has_value(), "what came back is a message");
}

std::vector<std::string> seeds() {
  std::vector<std::string> all;
  for (std::size_t i = 0; i < routes().size(); ++i) {
    const auto& from = routes()[i].there->from();
    ByteBuffer zeros;
    translate::serialize_default(*from, zeros);
    std::string seed(1, static_cast<char>(i));
    seed.append(reinterpret_cast<const char*>(zeros.data()), zeros.size());
    all.push_back(seed);
    for (std::size_t at = 1; at < seed.size(); at += 4) seed[at] = 1;  // arrays of one, strings of one letter
    all.push_back(seed + std::string(200, '\0'));
    // Zeros for the rest of a message whose first array has one element.
    all.push_back(all[all.size() - 2].substr(0, 1) + std::string("\1\0\0\0", 4) + std::string(400, '\0'));
  }
  return all;
}

}  // namespace extperfc::fuzz
