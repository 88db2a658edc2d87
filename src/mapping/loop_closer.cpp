#include "mapping/loop_closer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "mapping/map_parts.hpp"
#include "mapping/path_filter_common.hpp"
#include "mapping/rotation_by.hpp"

namespace extperfc::mapping {

namespace {

// References.
constexpr double kNearReachM = 0.6;  // a match finds its way from here
constexpr double kNearReachRad = 0.25;
constexpr std::size_t kMaxNear = 3;
constexpr std::size_t kMaxFar = 64;
constexpr std::size_t kMaxUnknown = 256;
constexpr double kUnknownApartM = 3.0;
// Search.
constexpr double kMaxWindowM = 40.0;
constexpr double kMaxWindowRad = 0.8;
constexpr double kSlackM = 0.3;
// Verification.
constexpr double kMinSupport = 0.2;
constexpr double kIndifferentSupport = 0.3;  // of a wrong match in a building of corridors
constexpr double kGoodSupport = 0.6;         // counts in full
constexpr double kMaxQuality = 1.5;
constexpr double kClearMargin = 0.12;  // of support, to the next best place
constexpr double kDeterminedM = 0.12;
// Acceptance.
constexpr double kMinWeight = 1.5;
constexpr double kMinWeightAtEnd = 0.6;
constexpr double kMinJoiningWeight = 4.5;  // of a part that may stand anywhere
constexpr std::size_t kMaxPool = 160;
constexpr std::size_t kOptimizeEvery = 8;

void keep_newest(std::vector<SubmapClosure>& pool) {
  if (pool.size() > kMaxPool) pool.erase(pool.begin(), pool.end() - static_cast<std::ptrdiff_t>(kMaxPool));
}

/// Where a query may stand in a reference's frame: within the graph's reach of its pose, and so near that
/// the two have much the same view. No value: nowhere.
std::optional<SearchWindow> window_of(const Pose2& expected, const RelativeUncertainty& known) {
  if (known.is_unknown()) return SearchWindow{{}, kOverlapM, M_PI};
  const double reach_m = std::min(kMaxWindowM, known.reach_m() + kSlackM);
  const double left = std::max(-kOverlapM, expected.x - reach_m);
  const double right = std::min(kOverlapM, expected.x + reach_m);
  const double bottom = std::max(-kOverlapM, expected.y - reach_m);
  const double top = std::min(kOverlapM, expected.y + reach_m);
  if (left > right || bottom > top) return std::nullopt;
  return on_grid({{(left + right) / 2, (bottom + top) / 2, expected.yaw},
                  std::max(right - left, top - bottom) / 2,
                  std::min(kMaxWindowRad, known.reach_rad() + 0.05)});
}

/// Takes back the loop closures of the key frames for which `is_chosen`.
template <typename IsChosen>
void forget_closures_at(const std::vector<KeyFrame>& frames, PoseGraph& graph, const IsChosen& is_chosen) {
  auto& constraints = graph.constraints();
  const auto is_forgotten = [&](const Constraint& constraint) {
    return constraint.is_loop_closure && !frames[constraint.to].is_thinned() &&
           (is_chosen(constraint.from) || is_chosen(constraint.to));
  };
  constraints.erase(std::remove_if(constraints.begin(), constraints.end(), is_forgotten), constraints.end());
  graph.optimize(0, kGraphIterations);
}

/// Key frames that were recognized in an older submap.
std::vector<bool> closed_frames(const PoseGraph& graph) {
  std::vector<bool> closed(graph.poses().size(), false);
  for (const Constraint& constraint : graph.constraints())
    if (constraint.is_loop_closure) closed[constraint.to] = true;
  return closed;
}

/// Where key frames that were recognized follow each other, with short gaps.
std::vector<LoopCloser::Pass> passes_in(const PoseGraph& graph) {
  constexpr std::size_t kGap = 16;  // key frames
  const auto closed = closed_frames(graph);
  std::vector<LoopCloser::Pass> passes;
  for (std::size_t i = 0; i < closed.size(); ++i) {
    if (!closed[i]) continue;
    if (passes.empty() || i - passes.back().end >= kGap) passes.push_back({i, i});
    passes.back().end = i + 1;
  }
  return passes;
}

/// From each key frame to the nearest of these, in key frames.
std::vector<std::size_t> frames_to(const std::vector<bool>& chosen) {
  std::vector<std::size_t> away;
  away.reserve(chosen.size());
  for (const bool is_chosen : chosen)
    away.push_back(is_chosen ? 0 : away.empty() ? chosen.size() : away.back() + 1);
  for (std::size_t i = chosen.size(); i-- > 1;) away[i - 1] = std::min(away[i - 1], away[i] + 1);
  return away;
}

}  // namespace

std::vector<std::size_t> LoopCloser::references(std::size_t query, const std::vector<KeyFrame>& frames,
                                                const PoseGraph& graph,
                                                const std::vector<RelativeUncertainty>& known) const {
  std::vector<std::pair<double, std::size_t>> found;
  const Pose2& here = graph.poses()[query];
  for (std::size_t i = kStride / 2; i + kMinLoopFrames < query; i += kStride) {
    if (frames[i].is_thinned()) continue;
    if (frames[query].travelled_m - frames[i].travelled_m < kMinLoopM) break;
    const double reach = known[i].is_unknown() ? std::numeric_limits<double>::infinity()
                                               : std::min(kMaxWindowM, known[i].reach_m());
    const double away = distance(graph.poses()[i], here);
    if (away < kOverlapM + reach) found.emplace_back(away, i);
  }
  std::sort(found.begin(), found.end());
  std::vector<std::size_t> references;
  references.reserve(found.size());
  for (const auto& [away, i] : found) references.push_back(i);
  return references;
}

bool LoopCloser::match_near(std::size_t reference, std::size_t query, const RelativeUncertainty& known,
                            const std::vector<KeyFrame>& frames, PoseGraph& graph) {
  const Pose2 expected = between(graph.poses()[reference], graph.poses()[query]);
  const auto closure = matcher_.verify({reference, query}, expected, frames, graph);
  if (!closure) return false;
  const Pose2 off = between(expected, closure->constraint.from_T_to);
  if (std::hypot(off.x, off.y) > known.reach_m() + 0.15 || std::abs(off.yaw) > known.reach_rad() + 0.05)
    return false;
  graph.add(closure->constraint);
  return true;
}

/// The peak as seen from the key frame nearest to it. Where parts of a building look alike, the support of
/// two places can be compared only if their submaps show as much of them.
LoopCloser::Peak LoopCloser::from_nearest(const Peak& peak, std::size_t query,
                                          const std::vector<RelativeUncertainty>& known,
                                          const std::vector<KeyFrame>& frames, const PoseGraph& graph) {
  constexpr std::size_t kStep = kStride / 2;
  constexpr std::size_t kFarthest = 6 * kStep;
  if (known[peak.reference].is_unknown()) return peak;
  const Pose2 place = compose(graph.poses()[peak.reference], peak.pose);
  std::size_t nearest = peak.reference;
  const std::size_t first = peak.reference - std::min(peak.reference / kStep * kStep, kFarthest);
  for (std::size_t i = first; i <= peak.reference + kFarthest && i + kMinLoopFrames < query; i += kStep) {
    if (frames[query].travelled_m - frames[i].travelled_m < kMinLoopM) break;
    if (frames[i].is_thinned() || known[i].is_unknown()) continue;
    if (distance(graph.poses()[i], place) < distance(graph.poses()[nearest], place)) nearest = i;
  }
  return {nearest, between(graph.poses()[nearest], place), peak.score};
}

/// Poses of the query in the references, as searched. Of one that may stand anywhere those that fit best.
std::vector<LoopCloser::Peak> LoopCloser::find_peaks(const std::vector<std::size_t>& references,
                                                     std::size_t query,
                                                     const std::vector<RelativeUncertainty>& known,
                                                     const std::vector<KeyFrame>& frames,
                                                     const PoseGraph& graph) {
  constexpr std::size_t kMaxAnywhere = 16;
  constexpr double kSameM = 0.3;
  constexpr double kSameRad = 0.1;
  std::vector<Peak> peaks;
  const auto add = [&](const Peak& peak) {  // several references may have led to it
    const bool is_known = std::any_of(peaks.begin(), peaks.end(), [&](const Peak& other) {
      return other.reference == peak.reference && near(other.pose, peak.pose, kSameM, kSameRad);
    });
    if (!is_known) peaks.push_back(peak);
  };
  for (const std::size_t reference : references) {
    const Pose2 expected = between(graph.poses()[reference], graph.poses()[query]);
    const auto window = window_of(expected, known[reference]);
    if (!window) continue;
    for (const FoundPose& found : matcher_.search({reference, query}, *window, frames, graph))
      add(from_nearest({reference, found.pose, found.score}, query, known, frames, graph));
  }
  if (references.empty() || !known[references.front()].is_unknown()) return peaks;
  std::stable_sort(peaks.begin(), peaks.end(),
                   [](const Peak& a, const Peak& b) { return a.score > b.score; });
  peaks.resize(std::min(peaks.size(), kMaxAnywhere));
  return peaks;
}

void LoopCloser::search_far(const std::vector<std::size_t>& references, std::size_t query,
                            const std::vector<RelativeUncertainty>& known,
                            const std::vector<KeyFrame>& frames, const PoseGraph& graph, Pool& pool) {
  const std::size_t first = pool.size();
  std::vector<Pose2> places;  // of the candidates, in the graph's frame
  for (const Peak& peak : find_peaks(references, query, known, frames, graph)) {
    const RelativeUncertainty& reach = known[peak.reference];
    auto closure = matcher_.verify({peak.reference, query}, peak.pose, frames, graph);
    if (!closure || closure->support < kMinSupport) continue;
    // Seen from the query, as the uncertainty is.
    const Pose2 found = inverse(closure->constraint.from_T_to);
    const Pose2 expected = between(graph.poses()[query], graph.poses()[peak.reference]);
    if (!is_explained({found.x - expected.x, found.y - expected.y, wrap_angle(found.yaw - expected.yaw)},
                      reach.covariance, reach.systematic_m + kSlackM))
      continue;
    closure->is_joining = reach.is_unknown();
    closure->reach_m = closure->is_joining ? ClosureSets::kUsualReachM : reach.reach_m();
    places.push_back(compose(graph.poses()[peak.reference], closure->constraint.from_T_to));
    pool.push_back(*closure);
  }
  for (std::size_t i = first; i < pool.size(); ++i) {
    double alternative = kMinSupport - kClearMargin;
    for (std::size_t k = first; k < pool.size(); ++k)
      if (!near(places[i - first], places[k - first], SubmapMatcher::kPeakApartM,
                SubmapMatcher::kPeakApartRad))
        alternative = std::max(alternative, pool[k].support);
    double clear = std::clamp((pool[i].support - alternative) / kClearMargin, 0.02, 1.0);
    if (widest_sigma_m(pool[i].constraint.covariance()) > kDeterminedM) clear = std::min(clear, 0.1);
    const double quality = (pool[i].support - kIndifferentSupport) / (kGoodSupport - kIndifferentSupport);
    pool[i].distinctness = clear * std::clamp(quality, 0.1, kMaxQuality);
  }
}

bool LoopCloser::accept(std::size_t first_new, double min_weight, const std::vector<KeyFrame>& frames,
                        Pool& pool, PoseGraph& graph) {
  if (first_new >= pool.size()) return false;
  const ClosureSets::Members accepted =
      ClosureSets(pool, frames, graph.poses(), uncertainties(graph)).best(first_new, min_weight);
  if (accepted.empty()) return false;
  const auto poses = graph.poses();
  const auto constraints = graph.constraints();
  const auto satisfied = [&] {
    double sum = 0;
    for (const Constraint& constraint : graph.constraints())
      if (constraint.is_loop_closure && graph.squared_error(constraint) < PoseGraph::kDoubtfulSquaredError)
        sum += constraint.fit;
    return sum;
  };
  const double before = satisfied();
  graph_changed();
  bring_together(graph, pool[accepted.front()].constraint);
  for (const std::size_t i : accepted) graph.add(pool[i].constraint);
  const bool solved = graph.optimize_gradually();
  std::size_t good = 0;
  for (std::size_t i = constraints.size(); i < graph.constraints().size(); ++i)
    if (graph.squared_error(graph.constraints()[i]) < PoseGraph::kDoubtfulSquaredError) ++good;
  const double after = satisfied();
  if (!solved || 5 * good < 4 * accepted.size() || after < before) {
    graph.constraints() = constraints;
    graph.set_poses(poses);
    return false;
  }
  pool.clear();  // what is left was searched from poses that were wrong
  return true;
}

bool LoopCloser::close(std::size_t query, const std::vector<KeyFrame>& frames, PoseGraph& graph) {
  if (frames[query].is_thinned()) return false;
  const auto known = uncertainties(graph).from(query);
  // What a query sees of a reference's uncertainty is as good as the reverse.
  std::vector<std::size_t> near_ones;
  std::vector<std::size_t> far_ones;
  std::vector<std::size_t> unknown_ones;
  for (const std::size_t i : references(query, frames, graph, known)) {
    const bool is_near = known[i].reach_m() < kNearReachM && known[i].reach_rad() < kNearReachRad;
    const bool is_unknown = known[i].is_unknown();
    auto& chosen = is_unknown ? unknown_ones : is_near ? near_ones : far_ones;
    const std::size_t max_count = is_unknown ? kMaxUnknown : is_near ? kMaxNear : kMaxFar;
    const bool new_pass = std::all_of(chosen.begin(), chosen.end(), [&](std::size_t other) {
      if (is_unknown) return distance(graph.poses()[i], graph.poses()[other]) > kUnknownApartM;
      return (i > other ? i - other : other - i) >= (is_near ? kOtherPassFrames : 2 * kStride);
    });
    if (new_pass && chosen.size() < max_count) chosen.push_back(i);
  }
  std::size_t matched = 0;
  for (const std::size_t i : near_ones) matched += match_near(i, query, known[i], frames, graph) ? 1 : 0;
  since_optimized_ += matched;
  if (matched > 0) graph_changed();
  if (since_optimized_ >= kOptimizeEvery) {
    graph.optimize(0, 3);
    since_optimized_ = 0;
  }
  if (matched > 0 && far_ones.size() > 4) far_ones.resize(4);
  const std::size_t first = pool_.size();
  if (!far_ones.empty()) search_far(far_ones, query, known, frames, graph, pool_);
  if (accept(first, kMinWeight, frames, pool_, graph)) return true;
  keep_newest(pool_);
  return join(unknown_ones, query, known, frames, graph);
}

/// Searches a query that may stand anywhere: once, since that takes long.
bool LoopCloser::join(const std::vector<std::size_t>& references, std::size_t query,
                      const std::vector<RelativeUncertainty>& known, const std::vector<KeyFrame>& frames,
                      PoseGraph& graph) {
  if (references.empty()) return false;
  const auto [found, is_new] = anywhere_.try_emplace(query);
  if (is_new) search_far(references, query, known, frames, graph, found->second);
  const std::size_t first = joining_.size();
  for (const SubmapClosure& closure : found->second)
    if (known[closure.constraint.from].is_unknown()) joining_.push_back(closure);
  if (accept(first, kMinJoiningWeight, frames, joining_, graph)) return true;
  keep_newest(joining_);
  return false;
}

/// Of thinned key frames closures stay, because they cannot be found again, and with them the path's shape.
void LoopCloser::forget_closures(const std::vector<KeyFrame>& frames, PoseGraph& graph) {
  auto& constraints = graph.constraints();
  constraints.erase(std::remove_if(constraints.begin(), constraints.end(),
                                   [&](const Constraint& constraint) {
                                     return constraint.is_loop_closure && !frames[constraint.to].is_thinned();
                                   }),
                    constraints.end());
  if (std::any_of(frames.begin(), frames.end(), [](const KeyFrame& frame) { return frame.is_thinned(); })) {
    graph.optimize(0, kGraphIterations);
    return;
  }
  auto poses = graph.poses();
  for (const Constraint& constraint : constraints)
    if (constraint.to == constraint.from + 1)
      poses[constraint.to] = compose(poses[constraint.from], constraint.from_T_to);
  graph.set_poses(poses);
}

double LoopCloser::close_all(const std::vector<KeyFrame>& frames, PoseGraph& graph) {
  if (frames.size() < 2) return 0;
  forget_closures(frames, graph);
  pool_.clear();
  joining_.clear();
  close_along(false, frames, graph);
  return close_more(frames, graph);
}

bool LoopCloser::close_open(const std::vector<KeyFrame>& frames, PoseGraph& graph) {
  const std::size_t before = graph.constraints().size();
  pool_.clear();
  joining_.clear();
  close_along(true, frames, graph);
  return graph.constraints().size() > before;
}

double LoopCloser::close_more(const std::vector<KeyFrame>& frames, PoseGraph& graph) {
  (void)close_open(frames, graph);
  return passes_.refine(frames, graph);
}

const RelativeUncertainties& LoopCloser::uncertainties(const PoseGraph& graph) {
  if (!uncertainties_) uncertainties_.emplace(graph);
  return *uncertainties_;
}

void LoopCloser::close_along(bool open_ones_only, const std::vector<KeyFrame>& frames, PoseGraph& graph) {
  graph_changed();
  const auto closed = closed_frames(graph);
  std::vector<std::size_t> queries;
  for (std::size_t query = kStride / 2; query < frames.size(); query += kStride)
    if (!open_ones_only || !closed[query]) queries.push_back(query);
  if (open_ones_only) {
    const auto away = frames_to(closed);
    std::stable_sort(queries.begin(), queries.end(),
                     [&](std::size_t a, std::size_t b) { return away[a] < away[b]; });
  }
  for (const std::size_t query : queries) (void)close(query, frames, graph);
  if (!pool_.empty()) (void)accept(0, kMinWeightAtEnd, frames, pool_, graph);
  if (!joining_.empty()) (void)accept(0, kMinJoiningWeight, frames, joining_, graph);
  pool_.clear();
  joining_.clear();
  graph.optimize(0, kGraphIterations);
  graph_changed();
}

std::vector<LoopCloser::Pass> LoopCloser::doubtful_passes(const PoseGraph& graph) {
  constexpr double kStrained = 25.0;  // chi-square of the steps between two passes
  const auto passes = passes_in(graph);
  std::vector<double> squared_errors(graph.poses().size() + 1, 0.0);  // of all steps before
  for (const Constraint& constraint : graph.constraints())
    if (!constraint.is_loop_closure) squared_errors[constraint.to + 1] += graph.squared_error(constraint);
  std::partial_sum(squared_errors.begin(), squared_errors.end(), squared_errors.begin());
  std::vector<std::pair<double, std::size_t>> strained;  // by how much, and the second of two passes
  for (std::size_t i = 1; i < passes.size(); ++i) {
    const std::size_t from = passes[i - 1].end - std::min(passes[i - 1].end, kStride);
    const std::size_t to = std::min(graph.poses().size(), passes[i].begin + kStride);
    const double strain = squared_errors[to] - squared_errors[from];
    if (strain > kStrained) strained.emplace_back(strain, i);
  }
  std::sort(strained.rbegin(), strained.rend());
  const auto length = [&](std::size_t i) { return passes[i].end - passes[i].begin; };
  std::vector<Pass> doubtful;
  for (const auto& [strain, i] : strained) {
    const bool first_is_shorter = length(i - 1) < length(i);
    doubtful.push_back(passes[first_is_shorter ? i - 1 : i]);
    doubtful.push_back(passes[first_is_shorter ? i : i - 1]);
  }
  return doubtful;
}

double LoopCloser::close_pass_again(const Pass& pass, const std::vector<KeyFrame>& frames, PoseGraph& graph) {
  std::vector<bool> joined(frames.size(), false);
  for (const Constraint& constraint : graph.constraints())
    if (constraint.is_loop_closure && constraint.to >= pass.begin && constraint.to < pass.end)
      joined[constraint.from] = joined[constraint.to] = true;
  const auto away = frames_to(joined);
  forget_closures_at(frames, graph, [&](std::size_t i) { return away[i] < kStride; });
  return close_more(frames, graph);
}

std::optional<double> LoopCloser::close_worst_again(const std::vector<KeyFrame>& frames, PoseGraph& graph,
                                                    std::vector<bool>& tried) {
  constexpr std::size_t kStretch = 48;  // key frames
  constexpr double kUsualFit = 0.6;
  constexpr double kBadly = 2.0;  // of fit that is lacking, summed over a stretch
  tried.resize(frames.size(), false);
  std::vector<double> lacking(frames.size() / kStretch + 1, 0.0);
  for (const Constraint& match : passes_.match_all(frames, graph.poses()))
    for (const std::size_t end : {match.from, match.to})
      if (!tried[end]) lacking[end / kStretch] += 0.5 * std::max(0.0, kUsualFit - match.fit);
  const auto worst = std::max_element(lacking.begin(), lacking.end());
  if (*worst < kBadly) return std::nullopt;
  const auto begin = static_cast<std::size_t>(worst - lacking.begin()) * kStretch;
  const std::size_t end = std::min(frames.size(), begin + kStretch);
  std::fill(tried.begin() + static_cast<std::ptrdiff_t>(begin),
            tried.begin() + static_cast<std::ptrdiff_t>(end), true);
  const auto inside = [&](std::size_t i) { return i + kStretch / 2 >= begin && i < end + kStretch / 2; };
  forget_closures_at(frames, graph, inside);
  return close_more(frames, graph);
}

}  // namespace extperfc::mapping
