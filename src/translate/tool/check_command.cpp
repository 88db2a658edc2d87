#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>
#include <utility>

#include "extperfc/base/arguments.hpp"

#include "translate/tool/command.hpp"
#include "translate/tool/comparison.hpp"
#include "translate/tool/live_master.hpp"
#include "translate/tool/report.hpp"
#include "translate/tool/sources.hpp"
#include "translate/tool/type_definitions.hpp"

namespace extperfc::translate {
namespace {

constexpr const char* kCheckHelp = R"(Compares the definitions of two sides, and lists what needs a rule.

  extperfc-translate check                                        the shipped sets: indigo and noetic
  extperfc-translate check --from-set SET --to-set SET            two sets of definitions
  extperfc-translate check --from-tree DIR[:DIR] --to-tree DIR    two trees of packages (a workspace's src,
                                                                  /opt/ros/*/share, a ROS_PACKAGE_PATH)
  extperfc-translate check --robot URI --workstation URI          two running masters, http://host:11311: types that
                                                                  nodes on both sides use
Sets, trees and masters may be combined. With a set and a tree for one side, the tree's types are compared, and the set
provides embedded types that the tree lacks. A set beside a master provides the types of topics that have subscribers but
no publisher, because only publishers report their MD5. The tool briefly subscribes to every publisher and probes every
service.

Verdicts: pass (only constants differ: the bytes are forwarded untouched), convert (both ways, by rules or by the
fields' names alone), needs a rule (with the reason), unknown (a definition is missing).

Options:
  --all           also types that are the same
  --fields        also the fields that come from a rule, get a default or are dropped, from robot to workstation
  --json          output as JSON
  --timeout SEC   timeout for a master and its nodes, 10 by default; types without an answer are unknown
  --rules FILE    these rules instead of those in the configuration; may be given several times
  --config DIR    the folder with definitions/ and the rules *.yaml

Exit status: 0 all pass or convert, 1 something needs a rule or is unknown, 2 an error occurred.
)";

/// The definitions of one side, "from" or "to", and a name for people.
struct Picked {
  TypeSet side;
  std::string name;
};

Result<std::chrono::milliseconds> seconds(const std::string& text) {
  constexpr double kMax = 3600;
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || end != text.c_str() + text.size() || !(value > 0 && value <= kMax))
    return fail(ErrorCode::kInvalidArgument, "--timeout must be a number of seconds up to 3600, not " + text);
  return std::chrono::milliseconds(static_cast<std::int64_t>(value * 1e3));
}

bool names_a_side(const Arguments& arguments) {
  for (const char* option :
       {"--from-set", "--to-set", "--from-tree", "--to-tree", "--robot", "--workstation"})
    if (arguments.has(option)) return true;
  return false;
}

Result<Picked> pick_set(const DefinitionStore& store, const std::string& set) {
  if (auto known = check_set(store, set); !known) return tl::unexpected(known.error());
  return Picked{types_of_set(store, set), "set " + set};
}

Result<Picked> pick(DefinitionStore& store, const Arguments& arguments, const std::string& side) {
  const auto set = arguments.last("--" + side + "-set");
  const auto tree = arguments.last("--" + side + "-tree");
  if (set)
    if (auto known = check_set(store, *set); !known) return tl::unexpected(known.error());
  const auto uri = arguments.last(side == "from" ? "--robot" : "--workstation");
  if (uri) {
    const auto patience = seconds(arguments.last("--timeout").value_or("10"));
    if (!patience) return tl::unexpected(patience.error());
    auto live = read_master(store, *uri, set.value_or(""), *patience);
    if (!live) return tl::unexpected(live.error());
    return Picked{*std::move(live), "master " + *uri};
  }
  if (!tree && !set)
    return fail(ErrorCode::kInvalidArgument, "give --" + side + "-set SET, --" + side + "-tree DIR or " +
                                                 (side == "from" ? "--robot URI" : "--workstation URI"));
  if (!tree) return Picked{types_of_set(store, *set), "set " + *set};
  const auto name = "tree-" + side;
  if (auto read = read_tree(store, *tree, name, set.value_or("")); !read) return tl::unexpected(read.error());
  return Picked{types_of_set(store, name), "tree " + *tree + (set ? " over set " + *set : "")};
}

}  // namespace

Result<int> run_check(const Tokens& tokens) {
  const auto arguments =
      Arguments::read(tokens, {0,
                               0,
                               {"--from-set", "--to-set", "--from-tree", "--to-tree", "--robot",
                                "--workstation", "--timeout", "--rules", "--config"},
                               {"--all", "--fields", "--json", "--help"}});
  if (!arguments) return tl::unexpected(arguments.error());
  if (arguments->has("--help")) {
    std::cout << kCheckHelp;
    return kFine;
  }
  auto store = open_store(*arguments);
  if (!store) return tl::unexpected(store.error());
  const bool any_side = names_a_side(*arguments);
  const auto from = any_side ? pick(*store, *arguments, "from") : pick_set(*store, "indigo");
  if (!from) return tl::unexpected(from.error());
  const auto to = any_side ? pick(*store, *arguments, "to") : pick_set(*store, "noetic");
  if (!to) return tl::unexpected(to.error());
  const auto files = rule_files(*arguments);
  if (!files) return tl::unexpected(files.error());
  const auto rules = load_rules(*files, *store);
  if (!rules) return tl::unexpected(rules.error());
  const auto comparison = compare(from->side, to->side, *rules);
  const ReportOptions options{arguments->has("--all"), arguments->has("--fields"), from->name, to->name};
  (arguments->has("--json") ? print_json : print_table)(std::cout, comparison, options);
  return all_well(comparison) ? kFine : kDiffers;
}

}  // namespace extperfc::translate
