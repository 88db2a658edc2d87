#include "extperfc/face/gallery.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "extperfc/base/text.hpp"

namespace extperfc::face {

namespace {

constexpr std::size_t kMaxNameBytes = 64;
constexpr float kLengthTolerance = 1e-3F;

float best_similarity(const Feature& feature, const std::vector<Feature>& known) {
  float best = -1.0F;
  for (const auto& other : known) best = std::max(best, similarity(feature, other));
  return best;
}

bool is_control(char c) {
  return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

Result<void> check_feature(const Feature& feature, const GallerySpec& spec) {
  if (feature.size() != spec.size)
    return fail(ErrorCode::kInvalidArgument, "a feature has " + std::to_string(feature.size()) +
                                                 " numbers, but those of the embedder \"" + spec.embedder +
                                                 "\" have " + std::to_string(spec.size));
  const float length = std::sqrt(similarity(feature, feature));
  if (std::abs(length - 1.0F) <= kLengthTolerance) return {};
  return fail(ErrorCode::kInvalidArgument, "a feature must have the length 1, not " + std::to_string(length));
}

}  // namespace

Result<void> check_name(const std::string& name) {
  if (!name.empty() && name.size() <= kMaxNameBytes && std::none_of(name.begin(), name.end(), is_control))
    return {};
  return fail(ErrorCode::kInvalidArgument,
              "the name " + in_quotes(name) +
                  " cannot be used: give one of 1 to 64 bytes without control characters");
}

Identity Gallery::identify(const Feature& feature, const IdentifyParams& params) const {
  Identity best;
  float second = -1.0F;
  bool first = true;
  for (const auto& [name, features] : people_) {
    const float similarity = best_similarity(feature, features);
    if (first || similarity > best.similarity) {
      if (!first) second = best.similarity;
      best = {name, similarity};
    } else {
      second = std::max(second, similarity);
    }
    first = false;
  }
  const bool is_ambiguous = people_.size() > 1 && best.similarity - second < params.margin;
  if (best.similarity < params.threshold || is_ambiguous) best.name.clear();
  return best;
}

Result<void> Gallery::add(const std::string& name, Feature feature) {
  if (auto checked = check_name(name); !checked) return checked;
  if (auto checked = check_feature(feature, spec_); !checked) return checked;
  if (people_.find(name) == people_.end() && people_.size() >= spec_.max_names)
    return fail(ErrorCode::kInvalidArgument,
                "the gallery is full: it has " + std::to_string(people_.size()) + " names: forget one first");
  auto& features = people_[name];
  features.push_back(std::move(feature));
  if (features.size() > spec_.max_features) features.erase(features.begin());
  return {};
}

std::size_t Gallery::forget(const std::string& name) {
  const auto found = people_.find(name);
  if (found == people_.end()) return 0;
  const std::size_t count = found->second.size();
  people_.erase(found);
  return count;
}

std::vector<std::string> Gallery::names() const {
  std::vector<std::string> names;
  for (const auto& [name, features] : people_) names.push_back(name);
  return names;
}

}  // namespace extperfc::face
