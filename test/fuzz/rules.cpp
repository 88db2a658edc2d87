// Rules as people write them, and worse: the loader over a few small definitions. What loads must work.
#include "extperfc/translate/rules.hpp"

#include "extperfc/translate/plan.hpp"

#include "test/fuzz/small_definitions.hpp"
#include "test/fuzz/target.hpp"

namespace extperfc::fuzz {

namespace {

using translate::ByteBuffer;
using translate::Plan;
using translate::RuleSet;

/// Runs each loaded rule on an empty message: it converts, or says why not.
void use(const RuleSet& rules) {
  for (const auto& rule : rules.rules()) {
    require(!rule.origin.empty(), "a rule knows where it stands");
    const auto from = small_definitions().find_message(rule.from_type, rule.from_md5);
    const auto to = small_definitions().find_message(rule.to_type, rule.to_md5);
    if (!from || !to) continue;  // halves of services are not found by themselves
    require(rules.find(*from, *to) == &rule, "a pair has one rule");
    const auto plan = Plan::compile(from, to, rules);
    require(plan.has_value(), "a rule that loads has a plan");
    ByteBuffer message, out;
    translate::serialize_default(*from, message);
    if (const auto done = (*plan)->convert(message.view(), out, 5); !done)
      require(!done.error().message.empty() && out.size() == 0, "a refusal has a reason and leaves nothing");
  }
}

}  // namespace

void run(std::string_view input) {
  const auto rules = parse_rules(std::string(input), "fuzzed.yaml", small_definitions());
  if (rules)
    use(*rules);
  else
    require(rules.error().message.rfind("fuzzed.yaml", 0) == 0, "a problem names the file");
}

std::vector<std::string> seeds() {
  const std::string head = "- type: p/Head\n  from: {md5: " + md5_of("old", "p/Head") +
                           ", name: old}\n  to: " + md5_of("new", "p/Head") + "\n";
  const std::string old_chain = md5_of("old", "p/Chain"), middle_chain = md5_of("middle", "p/Chain"),
                    new_chain = md5_of("new", "p/Chain");
  return {
      "rules: []\nrenames:\n  - {from: a_msgs, to: b_msgs}\n",
      head +
          "  forward:\n    ratio: {from: speed, scale: 0.01, offset: 1, overflow: saturate}\n"
          "    name: {from: \"names[2]\", otherwise: none}\n"
          "    poses: {from: poses, relative_to: base}\n"
          "    flags: {list: [{from: \"flags[1]\"}, {value: true}]}\n"
          "    stand: {fields: {position: {fields: {x: {from: base.position.y}}}}}\n"
          "    mode: {from: mode, map: {SLOW: WALK, 2: RUN}, otherwise: 0}\n"
          "    small: {value: -5}\n  drop_forward: [target]\n",
      head +
          "  backward:\n    speed: {from: ratio, scale: 100}\n    names: {list: [name, {value: x}]}\n"
          "    base: stand\n    flags: {value: [true, false, true]}\n    poses: {from: poses, relative_to: "
          "stand}\n"
          "  drop_backward: [small, stamp]\n",
      head +
          "  forward: {stand: {value: {position: {x: .nan}, orientation: {w: 1}}}, ratio: {value: .inf}, "
          "stamp: {value: 12.5}}\n",
      "rules:\n- type: p/Chain\n  from: " + old_chain + "\n  to: " + middle_chain +
          "\n  forward: {b: a}\n  backward: {a: b}\n- type: p/Chain\n  from: " + middle_chain +
          "\n  to: " + new_chain +
          "\n  forward: {c: {from: b, scale: 2}}\n  backward: {b: {from: c, overflow: saturate}}\n",
      "- service: p/Ask\n  from: " + md5_of("old", "p/Ask") + "\n  to: " + md5_of("new", "p/Ask") +
          "\n  request: {forward: {b: {value: 3}}}\n  response: {forward: {why: {value: ''}}, drop_backward: "
          "[why]}\n",
      "- &a [*a, {x: *a}]\n",
      "- from: {type: p/Head, md5: " + md5_of("old", "p/Head") +
          "}\n  to: {type: p/Chain, md5: " + new_chain + "}\n",
      "",
  };
}

}  // namespace extperfc::fuzz
