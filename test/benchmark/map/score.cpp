#include "test/benchmark/map/score.hpp"

#include "extperfc/offline/relations.hpp"
#include "extperfc/sources/scan_log.hpp"

#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

Result<void> add_score(const Recording& recording, const std::vector<std::optional<Pose2>>& poses,
                       Figures& figures) {
  const auto relations = offline::read_relations(recording.relations);
  if (!relations) return tl::unexpected(relations.error());
  auto log = sources::open_carmen_log(recording.log);
  if (!log) return tl::unexpected(log.error());
  const auto first = (*log)->next();
  if (!first) return tl::unexpected(first.error());
  if (!*first) return fail(ErrorCode::kCorrupt, recording.log.string() + " holds no scans");
  const auto score = offline::score_relations(*relations, poses, {(*first)->scan.base_T_sensor});
  figures["relations"] = static_cast<double>(score.all.relations);
  if (score.all.relations == 0) return {};
  figures["translation_m"] = score.all.translation_m.mean;
  figures["rotation_deg"] = score.all.rotation_deg.mean;
  if (score.loops.relations > 0) figures["worst_loop_m"] = score.loops.translation_m.worst;
  return {};
}

std::string summary(const Figures& figures) {
  const auto text = [&](const char* name) { return detail::number(figure_of(figures, name), "-"); };
  return text("translation_m") + " m, " + text("rotation_deg") + " deg, loop " + text("worst_loop_m") +
         " m, " + text("cpu_s") + " s, " + text("peak_mb") + " MB";
}

}  // namespace extperfc::benchmark
