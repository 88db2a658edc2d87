#include "offline/tool/score_report.hpp"

#include <array>
#include <iomanip>
#include <utility>

#include <nlohmann/json.hpp>

namespace extperfc::offline {

namespace {

std::array<std::pair<const char*, const GroupScore*>, 3> groups_of(const RelationsScore& score) {
  return {{{"all", &score.all}, {"neighbours", &score.neighbours}, {"loops", &score.loops}}};
}

void print_row(std::ostream& out, const char* name, const GroupScore& group) {
  out << "  " << std::left << std::setw(11) << name << std::right << std::setw(7) << group.relations;
  if (group.relations == 0) {
    out << "        -\n";
    return;
  }
  for (const auto* errors : {&group.translation_m, &group.rotation_deg})
    out << "  " << std::setprecision(4) << std::setw(9) << errors->mean << std::setw(9) << errors->deviation
        << std::setprecision(6) << std::setw(11) << errors->squared_mean << std::setw(11)
        << errors->squared_deviation << std::setprecision(3) << std::setw(9) << errors->worst;
  out << '\n';
}

nlohmann::json statistics_json(const ErrorStatistics& errors) {
  return {{"mean", errors.mean},
          {"std", errors.deviation},
          {"squared_mean", errors.squared_mean},
          {"squared_std", errors.squared_deviation},
          {"worst", errors.worst}};
}

}  // namespace

void print_score(std::ostream& out, const std::vector<Relation>& relations, const RelationsScore& score,
                 std::size_t worst) {
  const auto flags = out.flags();
  out << std::fixed << "relations: " << score.all.relations << " of " << relations.size() << " scored\n"
      << "                       translation [m]                                    rotation [deg]\n"
      << "               number       mean      std    squared        std    worst       mean      std    "
         "squared        std    worst\n";
  for (const auto& [name, group] : groups_of(score)) print_row(out, name, *group);
  const auto far_off = worst_relations(score, worst);
  if (!far_off.empty()) out << "  worst:\n";
  for (const auto& error : far_off)
    out << "    scans " << relations[error.relation].from << " and " << relations[error.relation].to << ": "
        << std::setprecision(3) << error.translation_m << " m, " << std::setprecision(2) << error.rotation_deg
        << " deg\n";
  out.flags(flags);
}

nlohmann::json score_json(const std::vector<Relation>& relations, const RelationsScore& score,
                          std::size_t worst) {
  nlohmann::json json{{"relations", relations.size()}, {"unmatched", score.unmatched}};
  for (const auto& [name, group] : groups_of(score))
    json[name] = {{"relations", group->relations},
                  {"translation_m", statistics_json(group->translation_m)},
                  {"rotation_deg", statistics_json(group->rotation_deg)}};
  json["worst"] = nlohmann::json::array();
  for (const auto& error : worst_relations(score, worst))
    json["worst"].push_back({{"from", relations[error.relation].from},
                             {"to", relations[error.relation].to},
                             {"translation_m", error.translation_m},
                             {"rotation_deg", error.rotation_deg}});
  return json;
}

}  // namespace extperfc::offline
